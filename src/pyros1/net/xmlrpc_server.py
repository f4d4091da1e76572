"""An XML-RPC server on a loop, which slow and broken peers cannot block.

For each connection, the server repeatedly reads, answers every complete request, and writes. While a response cannot be
written, nothing more is read from that peer. Sizes, numbers of connections and times are limited for every peer. When
there are too many connections, the one that has been idle longest is closed, so new ones are always served. (HTTP
clients reopen a kept-alive connection automatically.)

Each response contains the time of this machine's clock, so that clients can detect a wrong clock.
"""

from __future__ import annotations

import os
import socket
from collections import OrderedDict
from collections.abc import Callable, Sequence
from time import gmtime, monotonic, time
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from pyros1.ground.errors import Error, XmlRpcFault
from pyros1.net.acceptor import Acceptor
from pyros1.net.hosts import make_uri
from pyros1.net.loop import READ, WRITE
from pyros1.net.ports import listening_socket
from pyros1.net.socket_close import shutdown_and_close
from pyros1.net.timeouts import MIN_BYTES_PER_SECOND
from pyros1.wire.http import HttpError, HttpLimits, Request, RequestParser, build_response
from pyros1.wire.http_head import date_field
from pyros1.wire.xmlrpc import dumps_fault, dumps_response, loads_call

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist
    from pyros1.net.loop import Loop, TimerHandle
    from pyros1.net.ports import PortRange

Dispatch = Callable[[str, Sequence[Any]], Any]

_PATHS: Final = ("/", "/RPC2")
_RECEIVE_SIZE: Final = 256 * 1024
_TEXT_CONTENT_TYPE: Final = "text/plain"


class ServerLimits(NamedTuple):
    """Limits on the resources that peers may use.

    Attributes:
        http: maximum sizes of a request.
        max_connections: maximum number of open connections; never more than half of the files that this process may
            open.
        max_buffered: maximum number of bytes in incomplete requests, for all connections together.
        request_timeout_s: maximum pause in seconds while a request is received or a response is sent. A whole request
            may take longer if it arrives at MIN_BYTES_PER_SECOND or faster.
        idle_timeout_s: seconds after which a connection without a request is closed.
    """

    http: HttpLimits = HttpLimits()
    max_connections: int = 4096
    max_buffered: int = 256 * 1024 * 1024
    request_timeout_s: float = 30.0
    idle_timeout_s: float = 300.0


def make_unknown_method_fault(method: str) -> XmlRpcFault:
    """Return the fault to raise for a method that does not exist (M05)."""
    return XmlRpcFault(1, f'method "{method}" is not supported')


def multicall(dispatch: Dispatch, params: Sequence[Any]) -> list[Any]:
    """Serve ``system.multicall``: several calls in one (M04).

    Args:
        dispatch: makes one call.
        params: the call's parameters: a single list of structs with methodName and params.

    Returns:
        For each call, a list whose only item is the result, or a fault struct.

    Raises:
        XmlRpcFault: the parameters do not have this form.
    """
    if len(params) != 1 or not isinstance(params[0], list):
        raise XmlRpcFault(1, "system.multicall takes one list of calls")
    results: list[Any] = []
    for call in params[0]:
        try:
            if not isinstance(call, dict) or not isinstance(call.get("methodName"), str):
                raise XmlRpcFault(1, "system.multicall: a call is a struct with methodName and params")
            arguments = call.get("params", [])
            if not isinstance(arguments, list):
                raise XmlRpcFault(1, "system.multicall: params is a list")
            if call["methodName"] == "system.multicall":
                raise XmlRpcFault(1, "system.multicall: recursive calls are not supported")
            results.append([dispatch(call["methodName"], arguments)])
        except XmlRpcFault as fault:
            results.append({"faultCode": fault.code, "faultString": fault.message})
    return results


def _half_file_limit() -> int:
    """Return half of this process's limit of open files; 512 if the system does not report the limit."""
    max_files = os.sysconf("SC_OPEN_MAX") if hasattr(os, "sysconf") else 1024
    return max_files // 2 if max_files > 0 else 1 << 20  # -1: no limit


class _Connection:
    """The connection to one peer, with its incomplete request and unsent response."""

    def __init__(self, server: XmlRpcServer, sock: socket.socket) -> None:
        self.server = server
        self.sock = sock
        self.parser = RequestParser(server.limits.http)
        self.unsent = memoryview(b"")
        self.closes_after_response = False
        self.num_buffered = 0
        self.last_active_at = self.request_started_at = monotonic()
        server.loop.register(sock, READ, self._on_readable)

    def close(self) -> None:
        self.server.forget(self)
        self.server.loop.unregister(self.sock)
        shutdown_and_close(self.sock)

    def is_overdue(self, now: float) -> bool:
        limits = self.server.limits
        if self.unsent:
            return now - self.last_active_at > limits.request_timeout_s
        if self.parser.in_message:
            delay = max(
                now - self.last_active_at,
                now - self.request_started_at - self.parser.num_buffered / MIN_BYTES_PER_SECOND,
            )
            return delay > limits.request_timeout_s
        return now - self.last_active_at > limits.idle_timeout_s

    def _on_readable(self, mask: int) -> None:
        try:
            count = self.sock.recv_into(self.server.receive_buffer)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            self.close()
            return
        if not count:
            self.close()
            return
        self.last_active_at = monotonic()
        self.server.touch(self)
        if not self.parser.in_message:
            self.request_started_at = self.last_active_at
        self.parser.feed(self.server.receive_buffer[:count])
        self._serve()

    def _serve(self) -> None:
        """Answer every complete request that has arrived, as long as the responses can be written."""
        try:
            while self.parser.in_message and not self.unsent and not self.closes_after_response:
                request = self.parser.next_message()
                if request is None:
                    break
                self.request_started_at = self.last_active_at
                self.closes_after_response = not request.keep_alive
                self.server.caller_socket = self.sock
                self._write(self.server.respond(request))
        except HttpError as error:
            self.closes_after_response = True
            self._write(self.server.error_response(error.status, str(error), keep_alive=False))
        if not self.server.record_buffered(self, self.parser.num_buffered):
            self.close()

    def _write(self, data: bytes) -> None:
        sent = 0
        try:
            sent = self.sock.send(data)
        except (BlockingIOError, InterruptedError):
            pass
        except OSError:
            self.close()
            self.closes_after_response = True
            return
        if sent == len(data):
            if self.closes_after_response:
                self.close()
            return
        self.unsent = memoryview(data)[sent:]
        self.server.loop.modify(self.sock, WRITE, self._on_writable)

    def _on_writable(self, mask: int) -> None:
        try:
            sent = self.sock.send(self.unsent)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            self.close()
            return
        self.unsent = self.unsent[sent:]
        self.last_active_at = monotonic()
        self.server.touch(self)
        if self.unsent:
            return
        if self.closes_after_response:
            self.close()
            return
        self.request_started_at = self.last_active_at
        self.server.loop.modify(self.sock, READ, self._on_readable)
        self._serve()


class XmlRpcServer:
    """A server that listens as soon as it is created.

    Args:
        loop: the loop on which everything runs.
        dispatch: ``dispatch(method, params)`` returns a value or raises XmlRpcFault. It runs on the loop and must be
            quick. For ``system.multicall`` it is called several times.
        bind_host: the address to listen on, for example ``0.0.0.0`` or ``127.0.0.1``, or an IPv6 address.
        advertised_host: the host to use in ``uri``.
        port: the port; 0 lets the system choose.
        limits: limits on the resources that peers may use.
        ports: ports to choose from, if ``port`` is 0; None for any.
        allowlist: decides which peers may connect; None admits all.
        warn: called with a message when connections cannot be accepted; None to write it to stderr.

    Attributes:
        uri: ``http://host:port/``.
        port: the port that the server listens on.
        caller_socket: the socket of the current call's connection, for use by ``dispatch``.

    Raises:
        OSError: this machine cannot listen on the address, for example because the port is in use.
    """

    def __init__(
        self,
        loop: Loop,
        dispatch: Dispatch,
        *,
        bind_host: str,
        advertised_host: str,
        port: int = 0,
        limits: ServerLimits = ServerLimits(),  # noqa: B008 - immutable
        ports: PortRange | None = None,
        allowlist: Allowlist | None = None,
        warn: Callable[[str], object] | None = None,
    ) -> None:
        self.loop = loop
        self.limits = limits
        self._dispatch = dispatch
        self.caller_socket: socket.socket | None = None
        self._connections: OrderedDict[_Connection, None] = OrderedDict()  # least recently used first
        self._max_connections = min(limits.max_connections, _half_file_limit())
        self._num_buffered = 0
        self._sweep_timer: TimerHandle | None = None
        self._date_seconds = -1
        self._date_field = b""
        # Shared by all connections, since its contents are processed before the next read.
        self.receive_buffer = memoryview(bytearray(_RECEIVE_SIZE))
        listener = listening_socket(bind_host, port, ports)
        self.port: int = listener.getsockname()[1]
        self.uri = make_uri(advertised_host, self.port)
        self._acceptor = Acceptor(loop, listener, self._on_accepted, warn or loop.warn, self.make_room, allowlist)

    @property
    def num_connections(self) -> int:
        """Number of open connections."""
        return len(self._connections)

    def close(self) -> None:
        """Close the port and all connections. Thread-safe."""
        self.loop.run(self._close)

    def _close(self) -> None:
        self._acceptor.close()
        if self._sweep_timer is not None:
            self._sweep_timer.cancel()
        for connection in list(self._connections):
            connection.close()

    # ---- on the loop, for the connections

    def respond(self, request: Request) -> bytes:
        """Return the complete HTTP response to a request."""
        if request.method != "POST":
            return self.error_response(501, f"Unsupported method ({request.method!r})", keep_alive=request.keep_alive)
        if request.path not in _PATHS:
            return self.error_response(404, "No such page", keep_alive=request.keep_alive)
        if request.is_from_page:  # a website open in a browser on this machine must not control the robot
            return self.error_response(403, "Web pages may not call this", keep_alive=request.keep_alive)
        return build_response(
            200, self._call(request.body), keep_alive=request.keep_alive, date=self._make_date_field()
        )

    def error_response(self, status: int, text: str, *, keep_alive: bool) -> bytes:
        """Return the complete HTTP error response to a request that is not served."""
        return build_response(
            status, text.encode(), keep_alive=keep_alive, content_type=_TEXT_CONTENT_TYPE, date=self._make_date_field()
        )

    def _make_date_field(self) -> bytes:
        now = int(time())
        if now != self._date_seconds:
            self._date_seconds, self._date_field = now, date_field(gmtime(now))
        return self._date_field

    def _call(self, body: bytes) -> bytes:
        try:
            method, params = loads_call(body)
            if method == "system.multicall":
                return dumps_response(multicall(self._dispatch_guarded, params))
            return dumps_response(self._dispatch_guarded(method, params))
        except XmlRpcFault as fault:
            return dumps_fault(fault.code, fault.message)
        except Error as error:  # the peer's bytes are not a call, or the result cannot be written
            return dumps_fault(1, str(error))

    def _dispatch_guarded(self, method: str, params: Sequence[Any]) -> Any:
        """Return the result of a call; if the server itself fails, report the error and raise a fault."""
        try:
            return self._dispatch(method, params)
        except XmlRpcFault:
            raise
        except Exception as error:
            self.loop.report(error)
            raise XmlRpcFault(1, f"{type(error).__name__}: {error}") from error

    def forget(self, connection: _Connection) -> None:
        """Remove a connection that is being closed."""
        self._connections.pop(connection, None)
        self._num_buffered -= connection.num_buffered
        connection.num_buffered = 0

    def touch(self, connection: _Connection) -> None:
        """Record that a connection has received or sent bytes."""
        self._connections.move_to_end(connection)

    def record_buffered(self, connection: _Connection, num_buffered: int) -> bool:
        """Record the size of a connection's incomplete request; return False if all connections together have buffered
        too many bytes.
        """
        if num_buffered != connection.num_buffered and connection in self._connections:
            self._num_buffered += num_buffered - connection.num_buffered
            connection.num_buffered = num_buffered
        return self._num_buffered <= self.limits.max_buffered

    def _on_accepted(self, sock: socket.socket) -> None:
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if len(self._connections) >= self._max_connections:
            self.make_room()
        self._connections[_Connection(self, sock)] = None
        if self._sweep_timer is None:
            self._schedule_sweep()

    def make_room(self) -> None:
        """Close an idle connection, or if there is none, the connection with the oldest request. Called on the loop."""
        if not self._connections:
            return
        for connection in self._connections:
            if not connection.parser.in_message and not connection.unsent:
                connection.close()
                return
        min(self._connections, key=lambda each: each.request_started_at).close()

    def _schedule_sweep(self) -> None:
        period = min(self.limits.request_timeout_s, self.limits.idle_timeout_s) / 4
        self._sweep_timer = self.loop.call_later(period, self._sweep)

    def _sweep(self) -> None:
        self._sweep_timer = None
        now = monotonic()
        for connection in [each for each in self._connections if each.is_overdue(now)]:
            connection.close()
        if self._connections:
            self._schedule_sweep()
