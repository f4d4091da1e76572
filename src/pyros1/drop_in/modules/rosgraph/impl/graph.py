"""The graph of nodes and topics, updated from the master and the nodes (for rqt_graph and similar tools).

A topic's vertex is its name with a space in front, which distinguishes it from a node's vertex.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Iterator
from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.graph import NodeApi
from pyros1.ground.errors import Error
from rosgraph.masterapi import Master, MasterException

logger = logging.getLogger("rosgraph.graph")
_ROS_NAME = "/rosviz"
_NODE_TIMEOUT = 2.0

__getattr__ = module_getattr(__name__)


def topic_node(topic: str) -> str:
    """Return the vertex of a topic."""
    return " " + topic


def node_topic(node: str) -> str:
    """Return the topic that a vertex stands for."""
    return node[1:]


class BadNode:
    """A node that does not respond.

    Args:
        name: name of the node.
        type: ``DEAD``, or ``WONKY`` if it has responded before.
        reason: why it does not respond.
    """

    DEAD = 0
    WONKY = 1

    def __init__(self, name: str, type: int, reason: str) -> None:
        self.name = name
        self.type = type
        self.reason = reason


class Edge:
    """An edge between two vertices of the graph.

    Args:
        start, end: vertices.
        label: the topic of an edge between nodes.
    """

    __slots__ = ["start", "end", "label", "key", "rkey"]  # noqa: RUF023

    def __init__(self, start: str, end: str, label: str = "") -> None:
        self.start = start
        self.end = end
        self.label = label
        self.key = f"{start}|{label}"
        self.rkey = f"{end}|{label}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Edge) and (self.start, self.end) == (other.start, other.end)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        return f"{self.start}->{self.end}"


def edge_args(start: str, dest: str, direction: str, label: str) -> list[tuple[str, str, str]]:
    """Return (start, end, label) of each edge that a connection has; the direction is "i", "o" or "b" (both)."""
    edges = [(start, dest, label)] if direction in ("o", "b") else []
    return [*edges, (dest, start, label)] if direction in ("i", "b") else edges


class EdgeList:
    """Edges, indexed by both of their ends."""

    __slots__ = ["edges_by_start", "edges_by_end"]  # noqa: RUF023

    def __init__(self) -> None:
        self.edges_by_start: dict[str, list[Edge]] = {}
        self.edges_by_end: dict[str, list[Edge]] = {}

    def __iter__(self) -> Iterator[Edge]:
        return (edge for edges in list(self.edges_by_start.values()) for edge in list(edges))

    def has(self, edge: Edge) -> bool:
        """Return whether an edge exists."""
        return edge in self.edges_by_start.get(edge.key, ())

    __contains__ = has

    def add(self, edge: Edge) -> bool:
        """Add an edge; return whether it is new."""
        if self.has(edge):
            return False
        self.edges_by_start.setdefault(edge.key, []).append(edge)
        self.edges_by_end.setdefault(edge.rkey, []).append(edge)
        return True

    def add_edges(self, start: str, dest: str, direction: str, label: str = "") -> bool:
        """Add the edges of a connection (see `edge_args`); return whether one of them is new."""
        added = [self.add(Edge(*args)) for args in edge_args(start, dest, direction, label)]  # a list: all are added
        return any(added)

    def delete(self, edge: Edge) -> None:
        """Remove an edge."""
        for table, key in ((self.edges_by_start, edge.key), (self.edges_by_end, edge.rkey)):
            remaining = [other for other in table.get(key, ()) if other != edge]
            if remaining:
                table[key] = remaining
            else:
                table.pop(key, None)

    def delete_all(self, node: str) -> None:
        """Remove all edges that start or end at a vertex."""
        for edge in list(self):
            if node in (edge.start, edge.end):
                self.delete(edge)


class Graph:
    """The graph of nodes, topics and services.

    Args:
        node_ns, topic_ns: only nodes and topics in these namespaces are included.

    Attributes:
        nn_nodes: names of the nodes.
        nt_nodes: vertices of the topics.
        srvs: names of the services.
        nn_edges: edges between nodes that are connected, with the topic as the label.
        nt_edges: edges between nodes and topics, for connections.
        nt_all_edges: edges between nodes and topics, for all registrations.
        bad_nodes: nodes that do not respond, by name.
    """

    def __init__(self, node_ns: str = "/", topic_ns: str = "/") -> None:
        self.master = Master(_ROS_NAME)
        self.node_ns = node_ns or "/"
        self.topic_ns = topic_ns or "/"
        self.nn_nodes: set[str] = set()
        self.nt_nodes: set[str] = set()
        self.srvs: set[str] = set()
        self.nn_edges, self.nt_edges, self.nt_all_edges = EdgeList(), EdgeList(), EdgeList()
        self.bad_nodes: dict[str, BadNode] = {}
        self.bad_nodes_lock = threading.Lock()
        self.node_uri_map: dict[str, str] = {}
        self.uri_node_map: dict[str, str] = {}
        self.last_master_refresh = 0.0
        self.last_node_refresh: dict[str, float] = {}
        self.master_stale = 5.0
        self.node_stale = 5.0

    def set_master_stale(self, stale_secs: float) -> None:
        """Set the number of seconds after which the master is queried again."""
        self.master_stale = stale_secs

    def set_node_stale(self, stale_secs: float) -> None:
        """Set the number of seconds after which a node is queried again."""
        self.node_stale = stale_secs

    def update(self) -> bool:
        """Query the master and the nodes whose last responses are too old; return whether the graph has changed."""
        now = time.time()
        changed = False
        if now - self.last_master_refresh > self.master_stale:
            changed = self._master_refresh()
            self.last_master_refresh = time.time()
        for node in sorted(self.nn_nodes):
            if node not in self.bad_nodes and now - self.last_node_refresh.get(node, 0.0) > self.node_stale:
                changed = self._node_refresh(node) or changed
        return changed

    def bad_update(self) -> bool:
        """Query the nodes that did not respond; return whether the graph has changed."""
        changed = [self._node_refresh(node) for node in sorted(self.bad_nodes)]
        return any(changed)

    def _master_refresh(self) -> bool:
        try:
            publishers, subscribers, services = self.master.getSystemState()
        except (MasterException, OSError) as error:
            logger.error("cannot query the master: %s", error)
            return False
        nodes: set[str] = set()
        topics: set[str] = set()
        edges = EdgeList()
        for entries, direction in ((publishers, "o"), (subscribers, "i")):
            for topic, names in entries:
                if not topic.startswith(self.topic_ns):
                    continue
                topics.add(topic_node(topic))
                for node in names:
                    if node.startswith(self.node_ns):
                        nodes.add(node)
                        edges.add_edges(node, topic_node(topic), direction)
        nodes.update(node for _, names in services for node in names if node.startswith(self.node_ns))
        srvs = {name for name, _ in services}
        before = (self.nn_nodes, self.nt_nodes, self.srvs, sorted(map(str, self.nt_all_edges)))
        for removed in self.nn_nodes - nodes:
            self._remove_node(removed)
        self.nn_nodes, self.nt_nodes, self.srvs, self.nt_all_edges = nodes, topics, srvs, edges
        return before != (nodes, topics, srvs, sorted(map(str, edges)))

    def _remove_node(self, node: str) -> None:
        self.nn_edges.delete_all(node)
        self.nt_edges.delete_all(node)
        self.last_node_refresh.pop(node, None)
        self.uri_node_map.pop(self.node_uri_map.pop(node, ""), None)
        with self.bad_nodes_lock:
            self.bad_nodes.pop(node, None)

    def _node_refresh(self, node: str) -> bool:
        """Query a node for its connections; return whether there are new ones, or the node no longer responds."""
        is_first = node not in self.last_node_refresh
        try:
            uri = self._lookup_uri(node)
            api = NodeApi(_ROS_NAME, uri, _NODE_TIMEOUT)
            try:
                connections = api.connections()
            finally:
                api.close()
        except (MasterException, OSError, Error) as error:
            with self.bad_nodes_lock:
                was_bad = node in self.bad_nodes
                bad_type = BadNode.DEAD if is_first or was_bad else BadNode.WONKY
                self.bad_nodes[node] = BadNode(node, bad_type, str(error))
            return not was_bad
        self.last_node_refresh[node] = time.time()
        with self.bad_nodes_lock:
            changed = self.bad_nodes.pop(node, None) is not None
        for connection in connections:
            if not connection.connected or not connection.topic.startswith(self.topic_ns):
                continue
            peer_name = self._name_of(connection.destination)
            if peer_name is not None and peer_name.startswith(self.node_ns):
                changed = self.nn_edges.add_edges(node, peer_name, connection.direction, connection.topic) or changed
                changed = self.nt_edges.add_edges(node, topic_node(connection.topic), connection.direction) or changed
        return changed

    def _lookup_uri(self, node: str) -> str:
        uri = self.node_uri_map.get(node)
        if uri is None:
            uri = self.node_uri_map[node] = self.master.lookupNode(node)
            self.uri_node_map[uri] = node
        return uri

    def _name_of(self, destination: str) -> str | None:
        """Return the name of a connection's other node: ``destination`` itself, or the node with that address."""
        if not destination.startswith("http://"):
            return destination
        if destination not in self.uri_node_map:
            for node in self.nn_nodes - self.node_uri_map.keys():
                try:
                    self._lookup_uri(node)
                except (MasterException, OSError):
                    continue
        return self.uri_node_map.get(destination)
