"""The connections between nodes: which are expected, reported or missing. This module has no side effects."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pyros1.graph import Connection, SystemState


class Edge(NamedTuple):
    """An existing or expected connection, with the names of the topic and the nodes."""

    topic: str
    publisher: str
    subscriber: str


def expected_edges(state: SystemState) -> list[Edge]:
    """Return the connections that the master's registrations imply."""
    return [
        Edge(topic, publisher, subscriber)
        for topic, publishers in sorted(state.publishers.items())
        for publisher in publishers
        for subscriber in state.subscribers.get(topic, ())
    ]


def actual_edges(connections: Mapping[str, Iterable[Connection]], uris: Mapping[str, str]) -> dict[str, set[Edge]]:
    """Return the topic connections reported by each node.

    Args:
        connections: the result of ``getBusInfo`` by node name.
        uris: the API URIs by node name. Nodes report the peers of inbound connections by URI.
    """
    names_by_uri = {uri.rstrip("/"): name for name, uri in uris.items()}
    return {
        node: {
            Edge(connection.topic, node, names_by_uri.get(connection.destination.rstrip("/"), connection.destination))
            if connection.direction == "o"
            else Edge(
                connection.topic, names_by_uri.get(connection.destination.rstrip("/"), connection.destination), node
            )
            for connection in node_connections
            if connection.connected and connection.direction in ("i", "o")
        }
        for node, node_connections in connections.items()
    }


def is_missing_edge(edge: Edge, reported: Mapping[str, set[Edge]]) -> bool:
    """Return whether both ends of an expected connection respond, but at least one does not report it.

    One end is not sufficient, since rospy's subscribers report connections that they are still trying to establish.

    Args:
        edge: the connection.
        reported: the connections reported by each node that responds; see `actual_edges`.
    """
    reports = [reported.get(name) for name in (edge.publisher, edge.subscriber)]
    if edge.publisher == edge.subscriber:
        return reports[0] is not None and edge not in reports[0]
    return None not in reports and not all(edge in report for report in reports if report is not None)
