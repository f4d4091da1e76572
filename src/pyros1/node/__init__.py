"""The Node class, with its publishers, subscribers, services, parameters, clock and log."""

from pyros1.node.node import Node

__all__ = ["Node"]
