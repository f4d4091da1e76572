"""The ROS system as reported by the master and the nodes: nodes, topics, services, connections and traffic.

Measuring the traffic needs no subscriptions: nodes count what they send over each connection (``getBusStats``,
https://wiki.ros.org/ROS/Slave_API).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from math import isfinite
from time import monotonic
from typing import Any, NamedTuple

from pyros1.doctor.bridge_status import STATUS_SERVICE, fetch_status, find_providers
from pyros1.doctor.concurrent import run_concurrently
from pyros1.doctor.edges import Edge, actual_edges, expected_edges, is_missing_edge
from pyros1.graph import Connection, Graph, NodeApi
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import untrusted
from pyros1.web.transforms.bridges import describe_bridge
from pyros1.web.transforms.rates import CountMeter, Rate

NODE_TIMEOUT = 1.0
"""Timeout in seconds for requests to a node."""
_MAX_BRIDGES = 20
_MAX_COUNTED_CONNECTIONS = 100_000
"""Maximum number of connections per node and topic whose traffic is counted."""


_LENGTH_PREFIX_SIZE = 4
"""Size of a message's length prefix in bytes, which nodes count as well."""


class Flow(NamedTuple):
    """The number of messages that a node has sent over a connection, and their total size in bytes.

    Attributes:
        connection_id: the id that the node has given to the connection.
    """

    topic: str
    connection_id: Any
    messages: int
    bytes: int


class _NodeReport(NamedTuple):
    connections: list[Connection]
    flows: list[Flow]
    at: float


class System:
    """Describes the system for pages; rates are computed from the changes since earlier descriptions.

    Args:
        graph: sends requests to the master.
        clock: returns the time in seconds, for rates.
    """

    def __init__(self, graph: Graph, clock: Callable[[], float] = monotonic) -> None:
        self._graph = graph
        self._clock = clock
        self._lock = threading.Lock()
        self._uris: dict[str, str] = {}
        self._meters: dict[str, _Meters] = {}
        self._missing_edges: set[Edge] = set()
        self._latest_description: dict[str, Any] | None = None
        self._described_at = float("-inf")

    def describe(self, max_age: float) -> dict[str, Any]:
        """Return a description of the system as JSON.

        Args:
            max_age: the latest description is returned again if it is not older than this, in seconds.

        Returns:
            - nodes: name -> URI; silent: names of nodes that do not respond
            - topics: name -> type, publishers, subscribers, and the rates hz (messages per second) and bytes (per
              second), which are null while unknown, and missing if no publisher reports its traffic
            - services: name -> nodes
            - bridges: bridges to other masters, see `pyros1.web.transforms.bridges.describe_bridge`
            - edges: topic, publisher, subscriber, messages per second or null
            - missing: topic, publisher, subscriber of each connection that should exist, but was missing in the last
              two descriptions; a single time does not count, as new nodes need a moment to connect

        Raises:
            MasterUnreachableError: the master does not respond.
        """
        latest = self._latest_description
        if not self._lock.acquire(blocking=latest is None):
            assert latest is not None
            return latest  # another thread is already querying the nodes, which may take a while
        try:
            if self._latest_description is None or self._clock() - self._described_at >= max_age:
                self._latest_description = self._collect()
                self._described_at = self._clock()
            return self._latest_description
        finally:
            self._lock.release()

    def _collect(self) -> dict[str, Any]:
        state = self._graph.state()
        types = self._graph.topic_types()
        nodes = state.nodes()
        self._update_uris(nodes)
        queries = {name: partial(_query_node, self._graph, uri, self._clock) for name, uri in self._uris.items()}
        bridges = find_providers(state, STATUS_SERVICE)[:_MAX_BRIDGES]
        jobs: dict[tuple[str, str], Callable[[], object]] = {("node", name): job for name, job in queries.items()}
        jobs |= {("bridge", name): partial(fetch_status, self._graph, name, NODE_TIMEOUT) for name in bridges}
        answers = run_concurrently(jobs, NODE_TIMEOUT + 0.2)
        replies = {name: answers["node", name] for name in queries}
        statuses = {name: answers["bridge", name] for name in bridges}
        reports = {name: reply for name, reply in replies.items() if isinstance(reply, _NodeReport)}
        unreachable = [name for name in nodes if name not in reports]
        self._meters = {name: _update_meters(self._meters.get(name, {}), report) for name, report in reports.items()}
        rates = {name: _rates(meters) for name, meters in self._meters.items()}
        for name in unreachable:
            self._uris.pop(name, None)  # another process may have started under this name, with another URI
        reported = actual_edges({name: report.connections for name, report in reports.items()}, self._uris)
        edges = _edges_with_rates(reports, reported, rates)
        topics = {*state.publishers, *state.subscribers}
        currently_missing = [edge for edge in expected_edges(state) if is_missing_edge(edge, reported)]
        missing = [list(edge) for edge in currently_missing if edge in self._missing_edges]
        self._missing_edges = set(currently_missing)
        return {
            "nodes": {name: self._uris.get(name, "") for name in nodes},
            "silent": unreachable,
            "topics": {
                name: {
                    "type": types.get(name, ""),
                    "publishers": state.publishers.get(name, []),
                    "subscribers": state.subscribers.get(name, []),
                    **_topic_traffic(name, rates),
                }
                for name in sorted(topics)
            },
            "services": state.services,
            "bridges": [
                bridge
                for name, status in statuses.items()
                if isinstance(status, Mapping) and (bridge := describe_bridge(name, status))
            ],
            "edges": sorted(edge for edge in edges if edge[0] in topics),
            "missing": missing,
        }

    def _update_uris(self, nodes: Iterable[str]) -> None:
        uris = {name: uri for name in nodes if (uri := self._uris.get(name))}
        for name in nodes:
            if name not in uris:
                try:
                    uri = self._graph.node_uri(name)
                except Error:
                    uri = None
                if uri:
                    uris[name] = uri
        self._uris = uris


def _query_node(graph: Graph, uri: str, clock: Callable[[], float]) -> _NodeReport:
    node = graph.node_api(uri, NODE_TIMEOUT)
    try:
        connections = node.connections()
        return _NodeReport(connections, parse_flows(_bus_stats(node)), clock())
    finally:
        node.close()


def _bus_stats(node: NodeApi) -> Any:
    try:
        return node.bus_stats()
    except Error:
        return None  # roslisp, rosserial and others do not support getBusStats


def parse_flows(stats: Any) -> list[Flow]:
    """Return the traffic of a node's publications from the result of ``getBusStats``; malformed entries are ignored."""
    result: list[Flow] = []
    publications = stats[0] if isinstance(stats, list) and stats else None
    for entry in publications if isinstance(publications, list) else ():
        match entry:
            case [str(topic), _, list(connections)]:
                for connection in connections[:_MAX_COUNTED_CONNECTIONS]:
                    match connection:
                        case [connection_id, int() | float() as size, int() | float() as count, *_] if (
                            isfinite(size) and isfinite(count)  # numbers too large for XML-RPC are sent as floats
                        ):
                            body_bytes = max(0, int(size) - _LENGTH_PREFIX_SIZE * int(count))
                            result.append(Flow(untrusted(topic), connection_id, int(count), body_bytes))
    return result


_Meters = dict[tuple[str, Any], CountMeter]
"""(Topic, connection id) -> the meter of the traffic that was sent over the connection."""


def _update_meters(previous: _Meters, report: _NodeReport) -> _Meters:
    meters: _Meters = {}
    for topic, connection_id, messages, size in report.flows:
        if isinstance(connection_id, (int, str)):
            meter = meters[topic, connection_id] = previous.get((topic, connection_id)) or CountMeter(
                report.at, messages, size
            )
            meter.update(report.at, messages, size)
    return meters


def _rates(meters: _Meters) -> dict[str, dict[Any, Rate | None]]:
    """Return topic -> connection id -> rate; None while the rate is unknown."""
    rates: dict[str, dict[Any, Rate | None]] = {}
    for (topic, connection_id), meter in meters.items():
        rates.setdefault(topic, {})[connection_id] = meter.rate()
    return rates


_Rates = dict[str, dict[str, dict[Any, "Rate | None"]]]


def _topic_traffic(topic: str, rates: _Rates) -> dict[str, float | None]:
    """Return a topic's traffic: the sum of each publisher's fastest connection, as all carry the same messages."""
    publisher_rates = [node_rates[topic].values() for node_rates in rates.values() if node_rates.get(topic)]
    if not publisher_rates:
        return {}
    fastest = [
        max(known_rates)
        for connection_rates in publisher_rates
        if (known_rates := [rate for rate in connection_rates if rate])
    ]
    if not fastest:
        return {"hz": None, "bytes": None}
    return {"hz": sum(rate.hz for rate in fastest), "bytes": sum(rate.bytes for rate in fastest)}


def _edges_with_rates(
    reports: dict[str, _NodeReport], reported: Mapping[str, set[Edge]], rates: _Rates
) -> list[list[Any]]:
    rate_by_edge: dict[Edge, float | None] = {}
    for edges in reported.values():
        rate_by_edge.update(dict.fromkeys(edges))
    for name, report in reports.items():
        for topic, rate_by_id in rates.get(name, {}).items():
            connections = [each for each in report.connections if each.direction == "o" and each.topic == topic]
            for connection, rate in _match_rates(connections, rate_by_id):
                edge = Edge(topic, name, connection.destination)
                if edge in rate_by_edge:
                    rate_by_edge[edge] = rate and rate.hz
    return [[*edge, rate] for edge, rate in rate_by_edge.items()]


def _match_rates(
    connections: list[Connection], rate_by_id: Mapping[Any, Rate | None]
) -> Iterable[tuple[Connection, Rate | None]]:
    """Return a topic's connections with their rates. Some nodes report different ids for connections and rates."""
    if {str(connection.id) for connection in connections} == {str(connection_id) for connection_id in rate_by_id}:
        rate_by_id_text = {str(connection_id): rate for connection_id, rate in rate_by_id.items()}
        return [(connection, rate_by_id_text[str(connection.id)]) for connection in connections]
    if len(connections) == len(rate_by_id):
        return zip(connections, rate_by_id.values(), strict=True)
    return []  # a connection was added or removed between the two requests
