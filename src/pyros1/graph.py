"""Queries about a running system: the registrations with the master, and the states that nodes report.

The command line and the views share this module. It does not create a node, but only queries the XML-RPC APIs of the
master and the nodes (https://wiki.ros.org/ROS/Master_API, https://wiki.ros.org/ROS/Slave_API) and probes services.
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
from pyros1.net.spin_wait import POLLING_PAUSED

UNKNOWN_TYPE = "unknown type"
"""The displayed type of a topic whose type no node has reported to the master."""
NODE_TIMEOUT = 5.0
"""Timeout for a call to a node in seconds."""

PROBE_TIMEOUT = 5.0
"""Timeout in seconds for a service's provider to describe the service (L79)."""

_CONNECTION_INFO = re.compile(r"(?:TCPROS|LOCAL) connection on port (\d+) to \[(.*) on socket (\d+)\]")


class Master(Protocol):
    """The methods of MasterClient that this module uses."""

    caller_id: str

    def get_system_state(self) -> list[list[list[Any]]]: ...
    def get_published_topics(self, subgraph: str = "") -> list[list[str]]: ...
    def get_topic_types(self) -> list[list[str]]: ...
    def lookup_node(self, name: str) -> str: ...
    def lookup_service(self, service: str) -> str: ...


class SystemState(NamedTuple):
    """The names of the nodes registered as publishers, subscribers or service providers, by topic or service."""

    publishers: dict[str, list[str]]
    subscribers: dict[str, list[str]]
    services: dict[str, list[str]]

    def nodes(self) -> list[str]:
        """Return the names of all nodes in order of registration, without duplicates."""
        names: dict[str, None] = {}
        for table in (self.publishers, self.subscribers, self.services):
            for nodes in table.values():
                names.update(dict.fromkeys(nodes))
        return list(names)

    def of_node(self, name: str) -> NodeRegistrations:
        """Return the registrations of a node, sorted by name."""

        def registered_in(table: Mapping[str, list[str]]) -> list[str]:
            return sorted(entry for entry, nodes in table.items() if name in nodes)

        return NodeRegistrations(
            name, registered_in(self.publishers), registered_in(self.subscribers), registered_in(self.services)
        )


class NodeRegistrations(NamedTuple):
    """The names of the topics and services that a node has registered with the master."""

    name: str
    publications: list[str]
    subscriptions: list[str]
    services: list[str]


class Connection(NamedTuple):
    """A connection of a node, from its ``getBusInfo`` (S03).

    Attributes:
        destination: the peer's name (outbound) or API URI (inbound).
        direction: ``i`` for inbound, ``o`` for outbound or ``b`` for both.
        local_port, peer, socket: the port, peer and socket if the node reports them, otherwise None. LOCAL connections
            have port 0.
        polling_paused: whether the subscription has ``low_latency=True``, but its node does not poll for messages now,
            since its machine is busy.
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
    polling_paused: bool = False


class Graph:
    """Queries to a master and to registered nodes.

    Args:
        master: a MasterClient. All methods raise MasterUnreachableError if the master does not respond.
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
        """Return topic -> type, which may be ``*``, for all topics that ever had a type, in the master's order."""
        return {untrusted(entry[0]): untrusted(entry[1]) for entry in self.master.get_topic_types()}

    def published_types(self) -> dict[str, str]:
        """Return topic -> type for all topics that have a publisher."""
        return {untrusted(entry[0]): untrusted(entry[1]) for entry in self.master.get_published_topics("")}

    def find_topic(self, name: str) -> tuple[str, str, str] | None:
        """Split a name such as ``/topic/field`` into the registered topic and the path of the field.

        Returns:
            (topic, type, field path). The path is empty or begins with ``/`` or ``[``. None if there is no such topic
            or its type is unknown.
        """
        longest_match = None
        for topic, topic_type in self.topic_types().items():
            path = name[len(topic) :]
            if topic_type == "*" or not name.startswith(topic) or (path and path[0] not in "/["):
                continue
            if longest_match is None or len(topic) > len(longest_match[0]):
                longest_match = (topic, topic_type, path)
        return longest_match

    def node_uri(self, name: str) -> str | None:
        """Return the URI of a node's API; None if the node is not registered."""
        try:
            return self.master.lookup_node(name)
        except (MasterUnreachableError, MasterMethodError):
            raise
        except MasterError:
            return None

    def service_uri(self, name: str) -> str | None:
        """Return the ``rosrpc://`` URI of a service's provider; None if no node provides it."""
        try:
            return self.master.lookup_service(name)
        except (MasterUnreachableError, MasterMethodError):
            raise
        except MasterError:
            return None

    def node_api(self, uri: str, timeout: float = NODE_TIMEOUT) -> NodeApi:
        """Return a client for the API of the node with the given URI."""
        return NodeApi(self.master.caller_id, uri, timeout)


class NodeApi:
    """A client for the XML-RPC API of a node. Calls are made one after the other over one connection.

    Args:
        caller_id: the caller's name.
        uri: the URI of the node's API.
        timeout: the timeout for each call in seconds.

    All methods raise UnreachableError, DeadlineError, ProtocolError, MasterError (the node refused) or XmlRpcFault.
    """

    def __init__(self, caller_id: str, uri: str, timeout: float = NODE_TIMEOUT) -> None:
        from pyros1.net.xmlrpc_client import XmlRpcClient  # noqa: PLC0415 - not needed to list topics

        self.uri = uri
        self._caller_id = caller_id
        self._client = XmlRpcClient(uri, timeout=timeout)

    def _call(self, method: str, *args: Any) -> Any:
        from pyros1.net.master_client import unpack_reply  # noqa: PLC0415

        return unpack_reply(self._client.call(method, self._caller_id, *args), f"the node at {self.uri}")

    def pid(self) -> int:
        """Return the node's process id."""
        return cast(int, self._call("getPid"))

    def ping(self) -> float:
        """Return the node's response time in seconds."""
        start = monotonic()
        self.pid()
        return monotonic() - start

    def connections(self) -> list[Connection]:
        """Return the node's connections in the order in which it reports them."""
        entries = self._call("getBusInfo")
        if not isinstance(entries, list):
            raise ProtocolError(f"the node at {self.uri} answered getBusInfo with something other than a list")
        return [parse_bus_entry(entry) for entry in entries]

    def bus_stats(self) -> Any:
        """Return the connection statistics in the form that the node reports; roscpp nodes omit the status code."""
        response = self._client.call("getBusStats", self._caller_id)
        match response:
            case [int(), str(), value]:
                return value
        return response

    def subscriptions(self) -> dict[str, str]:
        """Return topic -> type for the topics that the node subscribes to."""
        entries = self._call("getSubscriptions")
        match entries:
            case list() if all(isinstance(entry, list) and len(entry) > 1 for entry in entries):
                return {untrusted(str(topic)): untrusted(str(type_)) for topic, type_, *_ in entries}
        raise ProtocolError(
            f"the node at {self.uri} answered getSubscriptions with something other than a list of pairs"
        )

    def shutdown(self, reason: str) -> None:
        """Ask the node to shut down."""
        self._call("shutdown", reason)

    def close(self) -> None:
        """Close the connection."""
        self._client.close()


def parse_bus_entry(entry: Any) -> Connection:
    """Return the connection that an entry of ``getBusInfo`` describes. The last two elements of the entry may be
    missing.

    Raises:
        ProtocolError: the argument is not an entry of ``getBusInfo``.
    """
    if not isinstance(entry, (list, tuple)) or len(entry) < 5:
        raise ProtocolError(f"not an entry of getBusInfo: {entry!r}"[:200])
    connection_id, destination, direction, transport, topic = entry[:5]
    connected = bool(entry[5]) if len(entry) > 5 else True
    description = entry[6] if len(entry) > 6 and isinstance(entry[6], str) else ""
    match = _CONNECTION_INFO.match(description)
    port, peer, sock = match.groups() if match else (None, None, None)
    destination, direction, transport, topic = (
        untrusted(str(part)) for part in (destination, direction, transport, topic)
    )
    return Connection(
        connection_id,
        destination,
        direction,
        transport,
        topic,
        connected,
        port,
        peer and untrusted(peer),
        sock,
        polling_paused=description.endswith(POLLING_PAUSED),
    )


def probe_service(name: str, uri: str, caller_id: str, timeout: float = PROBE_TIMEOUT) -> dict[str, str]:
    """Query and return the connection header of a service's provider without calling the service (L79).

    Args:
        name: the full name of the service.
        uri: the URI of the provider, ``rosrpc://host:port``.
        caller_id: the name of the caller.
        timeout: the timeout for the whole exchange in seconds.

    Returns:
        The provider's connection header, with type, md5sum, callerid and others.

    Raises:
        ServiceUnavailableError: the provider cannot be reached, does not respond, or does not provide the service.
    """
    from pyros1.net.hosts import parse_uri  # noqa: PLC0415
    from pyros1.wire.header import HeaderReader, encode_header  # noqa: PLC0415

    deadline = monotonic() + timeout
    request_header = {"probe": "1", "md5sum": "*", "callerid": caller_id, "service": name}
    try:
        with socket.create_connection(parse_uri(uri, "rosrpc"), timeout) as sock:
            sock.sendall(encode_header(request_header))
            reader = HeaderReader()
            header = None
            while header is None:
                sock.settimeout(max(0.001, deadline - monotonic()))
                received = sock.recv(4096)
                if not received:
                    raise UnreachableError("the connection was closed before the response")
                header = reader.feed(received)
    except (OSError, ProtocolError, UnreachableError, DeadlineError) as error:
        raise ServiceUnavailableError(f"service [{name}] at {uri} does not answer: {error}") from error
    if "error" in header:
        raise ServiceUnavailableError(f"service [{name}] at {uri}: {one_line(header['error'])}")
    return {field: untrusted(value) for field, value in header.items()}


def names_in_namespace(names: Iterable[str], namespace: str | None) -> list[str]:
    """Return the names that equal ``namespace`` or are below it; all names if ``namespace`` is None or the root."""
    if not namespace or namespace == SEP:
        return list(names)
    prefix = namespace.rstrip(SEP) + SEP
    return [name for name in names if name == namespace or name.startswith(prefix)]
