"""Nodes: publishers, subscribers, services, parameters, time and log of one program."""

from pyros1.node.node import Node

__all__ = ["Node"]
