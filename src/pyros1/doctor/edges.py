"""Which node is connected to which, as the nodes themselves say. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pyros1.graph import Connection, SystemState


class Edge(NamedTuple):
    """A connection, or one that should be: names of topic and nodes."""

    topic: str
    publisher: str
    subscriber: str


def expected_edges(state: SystemState) -> list[Edge]:
    """Return the connections that the master's registrations ask for."""
    return [
        Edge(topic, publisher, subscriber)
        for topic, publishers in sorted(state.publishers.items())
        for publisher in publishers
        for subscriber in state.subscribers.get(topic, ())
    ]


def actual_edges(connections: Mapping[str, Iterable[Connection]], uris: Mapping[str, str]) -> dict[str, set[Edge]]:
    """Return the topic connections that each node tells of.

    Args:
        connections: node name -> its ``getBusInfo``.
        uris: node name -> API URI: an inbound connection's other end is given by its URI.
    """
    names = {uri.rstrip("/"): name for name, uri in uris.items()}
    return {
        node: {
            Edge(c.topic, node, names.get(c.destination.rstrip("/"), c.destination))
            if c.direction == "o"
            else Edge(c.topic, names.get(c.destination.rstrip("/"), c.destination), node)
            for c in entries
            if c.connected and c.direction in ("i", "o")
        }
        for node, entries in connections.items()
    }
