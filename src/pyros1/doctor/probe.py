"""Sends requests with timeouts to individual nodes. The requests leave no traces in the nodes' logs."""

from __future__ import annotations

import socket
from time import monotonic, time

from pyros1.doctor.facts import HANGS, OTHER, REFUSED, TIMEOUT, UNRESOLVED, Failure, NodeFacts, ReportedType
from pyros1.graph import NodeApi
from pyros1.ground.errors import (
    DeadlineError,
    Error,
    LengthError,
    MasterError,
    MessageError,
    ProtocolError,
    UnreachableError,
    XmlRpcFault,
)
from pyros1.msgs import DefinitionCache
from pyros1.net.hosts import parse_uri
from pyros1.net.resolve import HostLookup
from pyros1.net.xmlrpc_client import XmlRpcClient
from pyros1.wire.header import HeaderReader, encode_header
from pyros1.wire.xmlrpc import dumps_call

NODE_TIMEOUT = 2.5
"""Timeout for a node's responses in seconds."""
CONNECT_TIMEOUT = 0.3
_MAX_BYTES = 1 << 20
"""Maximum size in bytes of a message that is inspected."""


def classify_error(error: BaseException) -> Failure:
    """Return the reason why a request failed, determined from its error and the causes of the error."""
    causes: list[BaseException] = []
    cause: BaseException | None = error
    while cause is not None:
        causes.append(cause)
        cause = cause.__cause__
    if any(isinstance(exception, (DeadlineError, TimeoutError)) for exception in causes):
        return Failure(TIMEOUT, str(error))
    if any(isinstance(exception, socket.gaierror) for exception in causes):
        return Failure(UNRESOLVED, str(error))
    if any(isinstance(exception, ConnectionError) for exception in causes):
        return Failure(REFUSED, str(error))
    if any(isinstance(exception, OSError) for exception in causes):  # no route to the host, network unreachable
        return Failure(TIMEOUT, str(error))
    return Failure(OTHER, str(error))


def resolve_host(host: str) -> list[str] | None:
    """Return the IP addresses of a host name; None if it cannot be resolved in time."""
    try:
        return HostLookup(host).wait(NODE_TIMEOUT)
    except OSError:
        return None


def _failure_reason(error: Error, uri: str) -> Failure:
    """Return the reason why a node did not respond. A new connection tells a node that hangs from one that is gone."""
    failure = classify_error(error)
    if failure.kind != TIMEOUT:
        return failure
    try:
        host, port = parse_uri(uri)
        addresses = HostLookup(host).wait(CONNECT_TIMEOUT)
    except (OSError, Error):
        return failure
    deadline = monotonic() + CONNECT_TIMEOUT
    num_refused = 0
    for address in addresses:
        try:
            socket.create_connection((address, port), max(0.01, deadline - monotonic())).close()
        except ConnectionRefusedError:
            num_refused += 1
        except OSError:
            pass
        else:
            return Failure(HANGS, failure.text)
    return Failure(REFUSED, failure.text) if addresses and num_refused == len(addresses) else failure


def probe_node(caller_id: str, uri: str) -> Failure | None:
    """Return the reason why a node does not respond; None if it does."""
    try:
        api = NodeApi(caller_id, uri, NODE_TIMEOUT)
    except ProtocolError as error:
        return Failure(OTHER, str(error))
    try:
        api.pid()
    except (MasterError, XmlRpcFault):
        pass  # the node responds, but does not report its process id
    except Error as error:
        return _failure_reason(error, uri)
    finally:
        api.close()
    return None


def query_node(caller_id: str, uri: str) -> NodeFacts:
    """Return the connections and the clock offset of a node, or the reason why they cannot be queried."""
    try:
        host, port = parse_uri(uri)
    except ProtocolError as error:
        return NodeFacts(uri, uri, None, Failure(OTHER, str(error)))
    ip_addresses = resolve_host(host)
    if ip_addresses is None:
        return NodeFacts(uri, host, None, Failure(UNRESOLVED, f"unknown host {host}"))
    facts = NodeFacts(uri, host, ip_addresses)
    api = NodeApi(caller_id, uri, NODE_TIMEOUT)
    try:
        facts.connections = api.connections()
        facts.clock_offset = clock_offset(caller_id, host, port)
    except Error as error:
        facts.failure = _failure_reason(error, uri)
    finally:
        api.close()
    return facts


def clock_offset(caller_id: str, host: str, port: int) -> float | None:
    """Return how far a machine's clock is ahead of ours in seconds, using the ``Date`` of a node's HTTP response.

    Returns:
        The offset, accurate to about a second; None if the response has no date.
    """
    import http.client  # noqa: PLC0415 - slow to import, and only needed for running systems
    from email.utils import parsedate_to_datetime  # noqa: PLC0415

    connection = http.client.HTTPConnection(host, port, timeout=NODE_TIMEOUT)
    try:
        sent_at = time()
        connection.request("POST", "/", dumps_call("getPid", (caller_id,)), {"Content-Type": "text/xml"})
        date = connection.getresponse().getheader("Date")
        now = (sent_at + time()) / 2
        if date is None:
            return None
        # The date is truncated to a whole second: half a second is lost on average.
        return parsedate_to_datetime(date).timestamp() + 0.5 - now
    except (OSError, http.client.HTTPException, ValueError, TypeError):
        return None
    finally:
        connection.close()


def query_publisher(caller_id: str, uri: str, topic: str, listen_seconds: float = 0.0) -> ReportedType:
    """Query a publisher like a subscriber that accepts any type; return its type, checksum and definition.

    Args:
        caller_id: the name of the caller.
        uri: the URI of the publisher's node.
        topic: the name of the topic.
        listen_seconds: the time in seconds to wait for a message, whose length is checked.
    """
    # Not the caller's own name: rospy would close the caller's subscription together with this connection (T63), and
    # clients of actions would take this connection for an action server's.
    caller_id = f"{caller_id}_query"
    api = XmlRpcClient(uri, timeout=NODE_TIMEOUT)
    try:
        code, text, protocol = api.call("requestTopic", caller_id, topic, [["TCPROS"]])
        if code != 1 or not protocol or protocol[0] != "TCPROS":
            return ReportedType(failure=Failure(OTHER, f"the node refuses the connection: {text}"))
        request_header = {"callerid": caller_id, "topic": topic, "type": "*", "md5sum": "*", "message_definition": ""}
        header, body = _exchange_headers(str(protocol[1]), int(protocol[2]), request_header, listen_seconds)
        if "error" in header:
            return ReportedType(failure=Failure(OTHER, f"the node refuses the connection: {header['error']}"))
        type_name, md5sum, definition = (
            header.get("type", "*"),
            header.get("md5sum", "*"),
            header.get("message_definition", ""),
        )
        return ReportedType(
            type_name,
            md5sum,
            None,
            definition,
            0 if body is None else _extra_bytes(type_name, md5sum, definition, body),
            header.get("latching") == "1",
        )
    except (Error, OSError, ValueError, TypeError, LookupError) as error:
        return ReportedType(failure=classify_error(error))
    finally:
        api.close()


def _exchange_headers(
    host: str, port: int, request_header: dict[str, str], listen_seconds: float = 0.0
) -> tuple[dict[str, str], bytes | None]:
    """Return a publisher's header, and the first message if one arrives within `listen_seconds`."""
    reader = HeaderReader()
    with socket.create_connection((host, port), NODE_TIMEOUT) as sock:
        sock.sendall(encode_header(request_header))
        header = _read_header(sock, reader, monotonic() + NODE_TIMEOUT)
        return header, _receive_message(
            sock, reader.bytes_after_header, monotonic() + listen_seconds
        ) if listen_seconds else None


def _receive_message(sock: socket.socket, data: bytes, deadline: float) -> bytes | None:
    """Receive and return a publisher's first message, of which ``data`` is the beginning.

    Return None if the message is too large or too late.
    """
    while (missing := _missing_bytes(data)) and monotonic() < deadline and len(data) + missing < _MAX_BYTES:
        sock.settimeout(max(0.001, deadline - monotonic()))
        try:
            chunk = sock.recv(missing)
        except OSError:
            return None
        if not chunk:
            return None
        data += chunk
    return None if missing else data[4 : 4 + int.from_bytes(data[:4], "little")]


def _missing_bytes(data: bytes) -> int:
    """Return the number of bytes that are missing until the frame is complete."""
    size = 4 + int.from_bytes(data[:4], "little") if len(data) >= 4 else 4
    return max(0, size - len(data))


def _extra_bytes(type_name: str, md5sum: str, definition: str, body: bytes) -> int:
    """Return the number of bytes after the end of a message; negative if bytes are missing, 0 if unknown."""
    try:
        message_class = DefinitionCache(prefer_installed=True).get(type_name, md5sum, definition)
        message_class._decode(body, 0, len(body), True)
    except LengthError as error:
        return error.surplus
    except MessageError:
        pass  # reported by another finding, or irrelevant here
    return 0


def _read_header(sock: socket.socket, reader: HeaderReader, deadline: float) -> dict[str, str]:
    while True:
        sock.settimeout(max(0.001, deadline - monotonic()))
        data = sock.recv(4096)
        if not data:
            raise UnreachableError("the connection was closed before the response")
        header = reader.feed(data)
        if header is not None:
            return header
