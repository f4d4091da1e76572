"""Queries about a running system: what the master knows, and what the nodes say about themselves.

Shared by the command line and the views. Nothing here is a node: it asks only the master and the nodes' XML-RPC APIs
(https://wiki.ros.org/ROS/Master_API, https://wiki.ros.org/ROS/Slave_API), and probes providers of services.
"""

from __future__ import annotations

import re
import socket
from collections.abc import Iterable, Mapping
from time import monotonic
from typing import Any, NamedTuple, Protocol, cast

from pyros1.ground.errors import (
    DeadlineError,
    MasterError,
    MasterMethodError,
    MasterUnreachableError,
    ProtocolError,
    ServiceUnavailableError,
    UnreachableError,
)
from pyros1.ground.names import SEP
from pyros1.ground.terminal_text import one_line, untrusted

UNKNOWN_TYPE = "unknown type"
"""Displayed as the type of a topic if no node has reported its type to the master."""
NODE_TIMEOUT = 5.0
"""Seconds that a node may take to answer one call."""

PROBE_TIMEOUT = 5.0
"""Seconds that a service's provider may take to describe the service (L79)."""

_INFO = re.compile(r"(?:TCPROS|LOCAL) connection on port (\d+) to \[(.*) on socket (\d+)\]")


class Master(Protocol):
    """The part of MasterClient that is needed here."""

    caller_id: str

    def get_system_state(self) -> list[list[list[Any]]]: ...
    def get_published_topics(self, subgraph: str = "") -> list[list[str]]: ...
    def get_topic_types(self) -> list[list[str]]: ...
    def lookup_node(self, name: str) -> str: ...
    def lookup_service(self, service: str) -> str: ...


class SystemState(NamedTuple):
    """Publishers, subscribers and services: name -> node names, in order of registration."""

    publishers: dict[str, list[str]]
    subscribers: dict[str, list[str]]
    services: dict[str, list[str]]

    def nodes(self) -> list[str]:
        """Return the names of all nodes, each once, in order of registration."""
        names: dict[str, None] = {}
        for table in (self.publishers, self.subscribers, self.services):
            for nodes in table.values():
                names.update(dict.fromkeys(nodes))
        return list(names)

    def of_node(self, name: str) -> NodeRegistrations:
        """Return one node's registrations, sorted by name."""

        def having(table: Mapping[str, list[str]]) -> list[str]:
            return sorted(entry for entry, nodes in table.items() if name in nodes)

        return NodeRegistrations(name, having(self.publishers), having(self.subscribers), having(self.services))


class NodeRegistrations(NamedTuple):
    """A node's registrations with the master: names of topics and services."""

    name: str
    publications: list[str]
    subscriptions: list[str]
    services: list[str]


class Connection(NamedTuple):
    """One entry of a node's ``getBusInfo`` (S03).

    Attributes:
        destination: the peer's name (outbound) or API URI (inbound).
        direction: ``i``, ``o`` or ``b``.
        local_port, peer, socket: of the connection, if its node reports them; else None. Ports of LOCAL ones are 0.
    """

    id: Any
    destination: str
    direction: str
    transport: str
    topic: str
    connected: bool
    local_port: str | None = None
    peer: str | None = None
    socket: str | None = None


class Graph:
    """Queries to a master, and to the nodes that it knows.

    Args:
        master: a MasterClient. All methods raise MasterUnreachableError if it does not answer.
    """

    def __init__(self, master: Master) -> None:
        self.master = master

    def state(self) -> SystemState:
        """Return the registrations of all nodes."""
        publishers, subscribers, services = (
            {untrusted(name): [*map(untrusted, nodes)] for name, nodes in table}
            for table in self.master.get_system_state()
        )
        return SystemState(publishers, subscribers, services)

    def topic_types(self) -> dict[str, str]:
        """Return the type of every topic that ever had one (topic -> type), ``*`` included, in the master's order."""
        return {untrusted(entry[0]): untrusted(entry[1]) for entry in self.master.get_topic_types()}

    def published_types(self) -> dict[str, str]:
        """Return the type of every topic that has a publisher (topic -> type)."""
        return {untrusted(entry[0]): untrusted(entry[1]) for entry in self.master.get_published_topics("")}

    def find_topic(self, name: str) -> tuple[str, str, str] | None:
        """Split a name such as ``/topic/field`` after the topic that the master knows.

        Returns:
            (topic, type, rest): rest is empty or begins with ``/`` or ``[``. None if there is no such topic, or its
            type is not known yet.
        """
        found = None
        for topic, topic_type in self.topic_types().items():
            rest = name[len(topic) :]
            if topic_type == "*" or not name.startswith(topic) or (rest and rest[0] not in "/["):
                continue
            if found is None or len(topic) > len(found[0]):
                found = (topic, topic_type, rest)
        return found

    def node_uri(self, name: str) -> str | None:
        """Return the API URI of a node, None if the master does not know it."""
        try:
            return self.master.lookup_node(name)
        except (MasterUnreachableError, MasterMethodError):
            raise
        except MasterError:
            return None

    def service_uri(self, name: str) -> str | None:
        """Return the ``rosrpc://`` URI of a service's provider, None if nobody provides it."""
        try:
            return self.master.lookup_service(name)
        except (MasterUnreachableError, MasterMethodError):
            raise
        except MasterError:
            return None

    def node(self, uri: str, timeout: float = NODE_TIMEOUT) -> NodeApi:
        """Return the API of the node at a URI."""
        return NodeApi(self.master.caller_id, uri, timeout)


class NodeApi:
    """The XML-RPC API of a node: calls go one after the other over one connection.

    Args:
        caller_id: the caller's name.
        uri: the node's API.
        timeout: seconds for each call.

    All methods raise UnreachableError, DeadlineError, ProtocolError, MasterError (the node refused) or XmlRpcFault.
    """

    def __init__(self, caller_id: str, uri: str, timeout: float = NODE_TIMEOUT) -> None:
        from pyros1.net.xmlrpc_client import XmlRpcClient  # noqa: PLC0415 - listing topics needs no node

        self.uri = uri
        self._caller_id = caller_id
        self._client = XmlRpcClient(uri, timeout=timeout)

    def _call(self, method: str, *args: Any) -> Any:
        from pyros1.net.master_client import unpack  # noqa: PLC0415

        return unpack(self._client.call(method, self._caller_id, *args), f"the node at {self.uri}")

    def pid(self) -> int:
        """Return the node's process id."""
        return cast(int, self._call("getPid"))

    def ping(self) -> float:
        """Return the seconds that the node took to answer."""
        start = monotonic()
        self.pid()
        return monotonic() - start

    def connections(self) -> list[Connection]:
        """Return the node's connections, in its own order."""
        entries = self._call("getBusInfo")
        if not isinstance(entries, list):
            raise ProtocolError(f"the node at {self.uri} answered getBusInfo with something other than a list")
        return [parse_bus_entry(entry) for entry in entries]

    def bus_stats(self) -> Any:
        """Return the node's connection statistics as it reports them; roscpp's come without a status code."""
        answer = self._client.call("getBusStats", self._caller_id)
        match answer:
            case [int(), str(), value]:
                return value
        return answer

    def subscriptions(self) -> dict[str, str]:
        """Return the topics that the node subscribes to, as (topic, type)."""
        entries = self._call("getSubscriptions")
        match entries:
            case list() if all(isinstance(entry, list) and len(entry) > 1 for entry in entries):
                return {untrusted(str(topic)): untrusted(str(type_)) for topic, type_, *_ in entries}
        raise ProtocolError(
            f"the node at {self.uri} answered getSubscriptions with something other than a list of pairs"
        )

    def shutdown(self, reason: str) -> None:
        """Tell the node to shut down."""
        self._call("shutdown", reason)

    def close(self) -> None:
        """Close the connection."""
        self._client.close()


def parse_bus_entry(entry: Any) -> Connection:
    """Read one entry of ``getBusInfo``; the last two elements may be missing.

    Raises:
        ProtocolError: it is not an entry of ``getBusInfo``.
    """
    if not isinstance(entry, (list, tuple)) or len(entry) < 5:
        raise ProtocolError(f"not an entry of getBusInfo: {entry!r}"[:200])
    number, destination, direction, transport, topic = entry[:5]
    connected = bool(entry[5]) if len(entry) > 5 else True
    match = _INFO.match(entry[6]) if len(entry) > 6 and isinstance(entry[6], str) else None
    port, peer, sock = match.groups() if match else (None, None, None)
    where, way, by, topic = (untrusted(str(word)) for word in (destination, direction, transport, topic))
    return Connection(number, where, way, by, topic, connected, port, peer and untrusted(peer), sock)


def probe_service(name: str, uri: str, caller_id: str, timeout: float = PROBE_TIMEOUT) -> dict[str, str]:
    """Ask a service's provider for its connection header, without calling the service (L79).

    Args:
        name: the service's full name.
        uri: ``rosrpc://host:port``.
        caller_id: the caller's name.
        timeout: seconds for the whole exchange.

    Returns:
        The provider's connection header: type, md5sum, callerid and more.

    Raises:
        ServiceUnavailableError: it cannot be reached, does not answer, or does not provide the service.
    """
    from pyros1.net.hosts import parse_uri  # noqa: PLC0415
    from pyros1.wire.header import HeaderReader, encode_header  # noqa: PLC0415

    deadline = monotonic() + timeout
    greeting = {"probe": "1", "md5sum": "*", "callerid": caller_id, "service": name}
    try:
        with socket.create_connection(parse_uri(uri, "rosrpc"), timeout) as sock:
            sock.sendall(encode_header(greeting))
            reader = HeaderReader()
            header = None
            while header is None:
                sock.settimeout(max(0.001, deadline - monotonic()))
                data = sock.recv(4096)
                if not data:
                    raise UnreachableError("the connection was closed before the answer")
                header = reader.feed(data)
    except (OSError, ProtocolError, UnreachableError, DeadlineError) as error:
        raise ServiceUnavailableError(f"service [{name}] at {uri} does not answer: {error}") from error
    if "error" in header:
        raise ServiceUnavailableError(f"service [{name}] at {uri}: {one_line(header['error'])}")
    return {name: untrusted(value) for name, value in header.items()}


def in_namespace(names: Iterable[str], namespace: str | None) -> list[str]:
    """Return the names that are ``namespace`` itself or lie below it; all names if it is None or the root."""
    if not namespace or namespace == SEP:
        return list(names)
    below = namespace.rstrip(SEP) + SEP
    return [name for name in names if name == namespace or name.startswith(below)]
