"""The connection of a client to a service that this node provides.

States::

    waiting ──────────────> answering ──────────────> closed
      ^   complete request      │   not persistent
      └─────────────────────────┘   persistent

* *waiting*: the loop waits for a complete request. A client that sends nothing, or one byte at a time, does not occupy
  a thread. A request that has started must be transferred at a minimum rate, see `TransferDeadline`; a client that is
  not persistent must start a request in time.
* *answering*: a worker's thread handles the request and sends the response. The worker also waits briefly for the first
  request, and for the next one of a persistent client, which is faster than waiting on the loop.
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.ground.errors import ProtocolError
from pyros1.net.loop import READ
from pyros1.net.socket_close import shutdown_and_close
from pyros1.net.spin_wait import SpinWait
from pyros1.net.timeouts import SOCKET_TIMEOUTS, TransferDeadline, set_socket_timeouts
from pyros1.wire.framing import FrameBuffer
from pyros1.wire.handshake import is_true
from pyros1.wire.service import encode_failure

if TYPE_CHECKING:
    from pyros1.net.loop import Loop, TimerHandle

REQUEST_TIMEOUT = 30.0
"""Maximum pause in seconds while a client sends a request or receives the response."""
LINGER_TIME = 0.05
"""Seconds that a worker waits for the next request of a persistent client."""

FrameRanges = list[tuple[int, int]]
"""(start, end) of each request's body in the buffer."""


class ClientConnection:
    """The connection of one client.

    Args:
        loop: the node's loop.
        sock: a connected, non-blocking socket.
        header: the client's connection header.
        initial_bytes: bytes that were received after the header.
        respond: ``respond(data, start, end, header)`` returns the encoded response to a request; called in a worker.
        submit: ``submit(job)`` runs a job in a worker and returns None, or returns the reason why that is not possible.
        may_linger: ``may_linger(count)`` returns whether a worker may wait for more requests after it has answered
            ``count`` of them.
        on_closed: called once, with this object and the error that closed it, or None.
    """

    def __init__(
        self,
        loop: Loop,
        sock: socket.socket,
        header: dict[str, str],
        initial_bytes: bytes,
        respond: Callable[[bytes, int, int, dict[str, str]], bytes],
        submit: Callable[[Callable[[], None]], str | None],
        may_linger: Callable[[int], bool],
        on_closed: Callable[[ClientConnection, Exception | None], None],
    ) -> None:
        self.header = header
        self._loop = loop
        self._sock = sock
        self._respond = respond
        self._submit = submit
        self._may_linger = may_linger
        self._on_closed = on_closed
        self._persistent = is_true(header.get("persistent"))
        self._buffer = FrameBuffer(4096, initial_bytes=initial_bytes)
        self._timer: TimerHandle | None = None
        self._transfer_deadline = TransferDeadline(REQUEST_TIMEOUT)  # used while the timer is set
        self._is_ending = False
        self._spin_wait = SpinWait()

    def begin(self, encoded_header: bytes) -> None:
        """Send the provider's header, encoded, and wait for a request. Called on the loop."""
        try:
            if self._sock.send(encoded_header) < len(encoded_header):
                raise ProtocolError("the client does not read its data")
            frames = self._buffer.received(0)
        except (OSError, ProtocolError) as error:
            self._close(error)
            return
        if frames:
            self._submit_requests(frames)
        elif not self._may_linger(0) or self._submit(lambda: self._serve([])) is not None:
            self._wait_for_request()

    def end(self) -> None:
        """Close the connection after the response to the current call, if any. Thread-safe."""
        self._is_ending = True
        with contextlib.suppress(OSError):
            self._sock.shutdown(socket.SHUT_RD)  # wakes a thread that waits for a request

    # ---- waiting, on the loop

    def _wait_for_request(self) -> None:
        if self._is_ending:
            self._close(None)
            return
        self._sock.setblocking(False)
        self._loop.register(self._sock, READ, self._on_readable)
        if self._buffer.has_partial_frame or not self._persistent:
            self._start_timeout()

    def _start_timeout(self) -> None:
        self._transfer_deadline = TransferDeadline(REQUEST_TIMEOUT)
        self._timer = self._loop.call_later(REQUEST_TIMEOUT, self._on_timeout)

    def _on_timeout(self) -> None:
        remaining = self._transfer_deadline.remaining()
        if remaining > 0:
            self._timer = self._loop.call_later(remaining, self._on_timeout)
            return
        self._loop.unregister(self._sock)
        is_partial = self._buffer.has_partial_frame
        self._close(ProtocolError(f"the request was not complete within {REQUEST_TIMEOUT:g} s") if is_partial else None)

    def _on_readable(self, _mask: int) -> None:
        is_new_request = not self._buffer.has_partial_frame
        try:
            count = self._sock.recv_into(self._buffer.writable())
            if not count:
                self._stop_waiting()
                self._close(None)
                return
            frames = self._buffer.received(count)
            self._transfer_deadline.add_bytes(count)
        except BlockingIOError:
            return
        except (OSError, ProtocolError) as error:
            self._stop_waiting()
            self._close(error)
            return
        if frames:
            self._stop_waiting()
            self._submit_requests(frames)
        elif is_new_request and self._timer is None:
            self._start_timeout()

    def _stop_waiting(self) -> None:
        self._loop.unregister(self._sock)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _submit_requests(self, frames: FrameRanges) -> None:
        if self._is_ending:  # bytes that arrived after `end` was called may have been read
            self._close(None)
            return
        reason = self._submit(lambda: self._serve(frames))
        if reason is not None:
            with contextlib.suppress(OSError):
                self._sock.send(encode_failure(reason))
            self._close(ProtocolError(reason))

    # ---- answering, in a worker

    def _serve(self, frames: FrameRanges) -> None:
        sock, buffer, header = self._sock, self._buffer, self.header
        num_answered = 0
        try:
            has_kernel_timeouts = set_socket_timeouts(sock, REQUEST_TIMEOUT, LINGER_TIME)
            while frames or (has_kernel_timeouts and not buffer.has_partial_frame and self._may_linger(num_answered)):
                frames = frames or self._linger()
                if not frames:
                    break
                data = buffer.take(frames)
                for start, end in frames:
                    sock.sendall(self._respond(data, start, end, header))
                    if not self._persistent or self._is_ending:
                        self._close(None)
                        return
                num_answered += len(frames)
                frames = []
        except SOCKET_TIMEOUTS:
            self._close(ProtocolError(f"the client did not read its response within {REQUEST_TIMEOUT:g} s"))
        except (OSError, ProtocolError) as error:
            self._close(error)
        else:
            self._loop.call_soon(self._wait_for_request)

    def _linger(self) -> FrameRanges:
        """Wait briefly for more requests; return their ranges in the buffer, or [] if none is complete by then.

        Raises:
            OSError: the client has disconnected, or the connection is being closed.
            ProtocolError: a request is too large.
        """
        try:
            count = self._spin_wait.wait(self._receive)
        except SOCKET_TIMEOUTS:
            return []
        if not count or self._is_ending:
            raise ConnectionError("closed")
        return self._buffer.received(count)

    def _receive(self, flags: int) -> int:
        return self._sock.recv_into(self._buffer.writable(), 0, flags)

    def _close(self, error: Exception | None) -> None:
        shutdown_and_close(self._sock)
        self._on_closed(self, error)
