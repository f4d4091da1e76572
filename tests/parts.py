"""The parts of a node in this process, found as other nodes of the process find them."""

from __future__ import annotations

from typing import Any

from pyros1.net.hosts import parse_uri
from pyros1.node import Node
from pyros1.node.context import Context, find_local_context


def context_of(node: Node) -> Context:
    """Return what the parts of a running node share."""
    context = find_local_context(node.uri)
    assert context is not None, "the node has ended"
    return context


def publication_of(node: Node, topic: str = "/t") -> Any:
    """Return what a node publishes on a topic."""
    return context_of(node).publications[topic]


def subscription_of(node: Node, topic: str = "/t") -> Any:
    """Return what a node subscribes to."""
    return context_of(node).subscriptions[topic]


def tcpros_port(node: Node) -> int:
    """Return the port where a node takes connections: every node offers a service, whose address has it."""
    return parse_uri(context_of(node).services[f"{node.name}/get_loggers"].uri, "rosrpc")[1]


def on_loop(node: Node) -> None:
    """Wait until a node's loop has done what it was given before."""
    context_of(node).loop.run(lambda: None, timeout=5)
