"""Makes many XML-RPC calls without blocking: one at a time and in order for each URI, in parallel for different URIs.

The states of a call are: queued -> connecting (unless an open connection exists) -> sent -> answered. If an open
connection turns out to have been closed by the peer, it is replaced once.
"""

from __future__ import annotations

import socket
from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from pyros1.ground.errors import DeadlineError, Error, ProtocolError, UnreachableError
from pyros1.net.acceptor import RETRY_DELAY, is_out_of_files
from pyros1.net.connect import ConnectHandle, connect
from pyros1.net.hosts import parse_uri
from pyros1.net.loop import READ, WRITE
from pyros1.net.timeouts import TransferDeadline, limit_unsent
from pyros1.wire.http import HttpLimits, Response, ResponseParser, build_request
from pyros1.wire.xmlrpc import dumps_call, loads_response

if TYPE_CHECKING:
    from pyros1.net.loop import Loop, TimerHandle

OnDone = Callable[[Any, "Error | None"], object]

_IDLE_TIMEOUT_S: Final = 30.0
_MAX_QUEUED: Final = 10_000
_RECEIVE_SIZE: Final = 64 * 1024


class _Job(NamedTuple):
    body: bytes
    on_done: OnDone
    timeout_s: float


class _Peer:
    """The connection to one URI, and the calls to it that are queued or in progress."""

    def __init__(self, caller: RpcCaller, uri: str, host: str, port: int) -> None:
        self.caller = caller
        self.loop = caller.loop
        self.uri = uri
        self.host = host
        self.port = port
        self.path = "/" + uri.partition("://")[2].partition("/")[2]
        self.queue: deque[_Job] = deque()
        self.current_job: _Job | None = None
        self.sock: socket.socket | None = None
        self.unsent = b""
        self.is_writing = False
        self.parser = ResponseParser(caller.limits)
        self.is_new_connection = True
        self.pending_connect: ConnectHandle | TimerHandle | None = None  # a timer while there are too many open files
        self.connect_error: Error | None = None  # the error while there are too many open files
        self.deadline_timer: TimerHandle | None = None
        self.transfer_deadline = TransferDeadline(0.0)  # the deadline of the current call
        self.idle_timer: TimerHandle | None = None

    def add(self, job: _Job) -> None:
        if len(self.queue) >= _MAX_QUEUED:
            job.on_done(None, UnreachableError(f"{self.uri} does not answer: {_MAX_QUEUED} calls are queued"))
            return
        self.queue.append(job)
        if self.current_job is None:
            self._start_next()

    def close(self) -> None:
        self._disconnect()
        jobs = [self.current_job] if self.current_job else []
        jobs += self.queue
        self.current_job = None
        self.queue.clear()
        if self.deadline_timer is not None:
            self.deadline_timer.cancel()
        for job in jobs:
            job.on_done(None, UnreachableError(f"the call to {self.uri} was cancelled: its caller was closed"))

    def _start_next(self) -> None:
        if self.idle_timer is not None:
            self.idle_timer.cancel()
            self.idle_timer = None
        if not self.queue:
            if self.sock is None:
                self.caller.forget(self)
            else:
                self.idle_timer = self.loop.call_later(_IDLE_TIMEOUT_S, self.close_if_idle)
            return
        job = self.current_job = self.queue.popleft()
        self.transfer_deadline = TransferDeadline(job.timeout_s)
        self.deadline_timer = self.loop.call_later(job.timeout_s, self._on_deadline, job)
        if self.sock is not None:
            self.is_new_connection = False
            self._send()
        else:
            self._connect()

    def _connect(self) -> None:
        self.is_new_connection = True
        job = self.current_job
        if job is None:
            return
        self.pending_connect = None
        handle = connect(self.loop, self.host, self.port, job.timeout_s + 1.0, self._on_connect_result)
        if handle.pending:
            self.pending_connect = handle

    def _on_connect_result(self, sock: socket.socket | None, error: Error | None) -> None:
        is_immediate = self.pending_connect is None
        self.pending_connect = None
        if sock is None and is_out_of_files(error):  # try again until the call's deadline
            self.connect_error = error
            self.caller.close_idle_connections()
            self.pending_connect = self.loop.call_later(RETRY_DELAY, self._connect)
            return
        if sock is None and is_immediate:  # called later to prevent recursion: the next call may fail immediately too
            self.loop.call_soon(self._on_connect_failed, self.current_job, error)
            return
        if sock is None:
            self._finish(None, error)
            return
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        limit_unsent(sock)
        self.sock, self.connect_error = sock, None
        self.parser = ResponseParser(self.caller.limits)
        self.loop.register(sock, READ, self._on_ready)
        self._send()

    def _on_connect_failed(self, job: _Job | None, error: Error | None) -> None:
        if job is self.current_job:  # the job has not timed out meanwhile
            self._finish(None, error)

    def _send(self) -> None:
        job = self.current_job
        if job is None:
            return
        self.unsent = build_request(f"{self.host}:{self.port}", self.path, job.body)
        self._write()

    def _write(self) -> None:
        sock = self.sock
        if sock is None:
            return
        try:
            sent = sock.send(self.unsent)
        except (BlockingIOError, InterruptedError):
            sent = 0
        except OSError as error:
            self._on_connection_lost(error.strerror or str(error))
            return
        self.unsent = self.unsent[sent:]
        self.transfer_deadline.add_bytes(sent)
        if bool(self.unsent) is not self.is_writing:
            self.is_writing = not self.is_writing
            self.loop.modify(sock, READ | WRITE if self.is_writing else READ, self._on_ready)

    def _on_ready(self, mask: int) -> None:
        if mask & READ:
            self._read()
        if mask & WRITE and self.unsent:
            self._write()

    def _read(self) -> None:
        sock = self.sock
        if sock is None:
            return
        try:
            data = sock.recv(_RECEIVE_SIZE)
        except (BlockingIOError, InterruptedError):
            return
        except OSError as error:
            self._on_connection_lost(error.strerror or str(error))
            return
        if self.current_job is None:  # the peer has closed the idle connection, or sent unexpected bytes
            self._disconnect()
            self.caller.forget(self)
            self.caller.on_disconnect(self.uri)
            return
        self.transfer_deadline.add_bytes(len(data))
        try:
            if data:
                self.parser.feed(data)
                response = self.parser.next_message()
            else:
                response = self.parser.eof()
                if response is None:
                    self._on_connection_lost("the connection was closed before a response arrived")
                    return
        except ProtocolError as error:
            self._disconnect()
            self._finish(None, ProtocolError(f"{self.uri}: {error}"))
            return
        if response is not None:
            self._on_response(response)

    def _on_response(self, response: Response) -> None:
        if not response.keep_alive or self.parser.in_message or self.unsent:
            self._disconnect()
        value: Any = None
        error: Error | None = None
        if response.status != 200:
            error = ProtocolError(f"{self.uri} answered with HTTP status {response.status}")
        else:
            try:
                value = loads_response(response.body)
            except Error as failure:
                error = failure
        self._finish(value, error)

    def _on_connection_lost(self, reason: str) -> None:
        has_response_started = self.parser.in_message
        self._disconnect()
        if self.current_job is None:
            self.caller.forget(self)
            self.caller.on_disconnect(self.uri)
        elif self.is_new_connection or has_response_started:
            self._finish(None, UnreachableError(f"cannot reach {self.uri}: {reason}"))
        else:
            self._connect()

    def _on_deadline(self, job: _Job) -> None:
        if job is not self.current_job:
            return
        remaining = self.transfer_deadline.remaining()
        if remaining > 0:
            self.deadline_timer = self.loop.call_later(remaining, self._on_deadline, job)
        else:
            self._disconnect()
            self._finish(
                None, self.connect_error or DeadlineError(f"{self.uri} did not answer within {job.timeout_s:g} s")
            )

    def _finish(self, value: Any, error: Error | None) -> None:
        job, self.current_job, self.connect_error = self.current_job, None, None
        if self.deadline_timer is not None:
            self.deadline_timer.cancel()
            self.deadline_timer = None
        try:
            if job is not None:
                job.on_done(value, error)
        finally:
            # If the callback has added a job, that job has been started already.
            if self.current_job is None:
                self._start_next()

    def close_if_idle(self) -> None:
        """Close the connection, unless a call is in progress."""
        if self.current_job is None:
            self._disconnect()
            self.caller.forget(self)

    def _disconnect(self) -> None:
        self.unsent = b""
        self.is_writing = False
        if self.idle_timer is not None:
            self.idle_timer.cancel()
            self.idle_timer = None
        if self.pending_connect is not None:
            self.pending_connect.cancel()
            self.pending_connect = None
        if self.sock is not None:
            self.loop.unregister(self.sock)
            self.sock.close()
            self.sock = None


class RpcCaller:
    """Calls methods at any number of URIs.

    Args:
        loop: the loop on which everything runs.
        timeout: maximum number of seconds for a call, including connecting but not the time in the queue; extended
            while a large amount of data is transferred (`TransferDeadline`).
        limits: maximum sizes of a response.
        on_disconnect: called on the loop with the URI when the peer closes an idle connection.

    Attributes:
        make_room: called when this process has too many open files and this object has no idle connection to close;
            closes another connection that is not needed.
    """

    def __init__(
        self,
        loop: Loop,
        *,
        timeout: float = 10.0,
        limits: HttpLimits = HttpLimits(),  # noqa: B008 - immutable
        on_disconnect: Callable[[str], object] = lambda uri: None,
    ) -> None:
        self.loop = loop
        self.on_disconnect = on_disconnect
        self.limits = limits
        self._timeout = timeout
        self._peers: dict[str, _Peer] = {}
        self._closed = False
        self.make_room: Callable[[], object] = lambda: None

    def call(self, uri: str, method: str, params: Sequence[Any], on_done: OnDone, timeout: float | None = None) -> None:
        """Queue a call. Thread-safe.

        Args:
            uri: ``http://host:port/``.
            method: the name of the method.
            params: the method's arguments.
            on_done: called once on the loop: ``(value, None)``, or ``(None, error)`` with an UnreachableError,
                DeadlineError, ProtocolError or XmlRpcFault. Not called if the loop stops first.
            timeout: maximum number of seconds for this call; None for this object's ``timeout``.

        Raises:
            SerializationError: an argument cannot be encoded.
        """
        job = _Job(dumps_call(method, params), on_done, self._timeout if timeout is None else timeout)
        if self.loop.in_loop():
            self._call(uri, job)
        else:
            self.loop.call_soon(self._call, uri, job)

    def close(self) -> None:
        """Cancel all calls (with an UnreachableError) and close all connections. Thread-safe."""
        self.loop.run(self._close)

    def close_idle_connections(self) -> None:
        """Close the idle connections; if there are none, call `make_room`. Called by `_Peer` objects."""
        idle_peers = [peer for peer in self._peers.values() if peer.idle_timer is not None]
        for peer in idle_peers:
            peer.close_if_idle()
        if not idle_peers:
            self.make_room()

    def forget(self, peer: _Peer) -> None:
        """Remove the state of a URI that has no connection and no calls. Called by `_Peer` objects."""
        if self._peers.get(peer.uri) is peer:
            del self._peers[peer.uri]

    def _call(self, uri: str, job: _Job) -> None:
        if self._closed:
            # called later to prevent recursion: `on_done` may make the next one of a thousand calls
            error = UnreachableError(f"the call to {uri} was cancelled: its caller was closed")
            self.loop.call_soon(job.on_done, None, error)
            return
        peer = self._peers.get(uri)
        if peer is None:
            try:
                host, port = parse_uri(uri)
            except ProtocolError as error:
                job.on_done(None, error)
                return
            peer = self._peers[uri] = _Peer(self, uri, host, port)
        peer.add(job)

    def _close(self) -> None:
        self._closed = True
        peers = list(self._peers.values())
        self._peers.clear()
        for peer in peers:
            peer.close()
