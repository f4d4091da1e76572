"""A client's connection to a service that this node provides.

States::

    waiting ──────────────> answering ──────────────> closed
      ^   a whole request       │   not persistent
      └─────────────────────────┘   persistent

* *waiting*: on the loop, for a whole request. A client that sends nothing, or one byte at a time, costs no thread. A
  request must go on once it has begun, and not slower than SLOWEST in the long run; a client that is not persistent
  must begin it.
* *answering*: in a worker's thread, until the response is sent. It also waits there, for a moment, for the first
  request and for the next one of a persistent client: that saves the detour over the loop.
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.ground.errors import ProtocolError
from pyros1.net.closing import hang_up
from pyros1.net.eager import Eager
from pyros1.net.loop import READ
from pyros1.net.timeouts import Patience, WaitOver, bound_waits
from pyros1.wire.framing import FrameBuffer
from pyros1.wire.handshake import is_true
from pyros1.wire.service import encode_failure

if TYPE_CHECKING:
    from pyros1.net.loop import Loop, TimerHandle

REQUEST_TIMEOUT = 30.0
"""Longest pause, in seconds, of a client that sends a request, or takes the response."""
LINGER = 0.05
"""Seconds that a worker waits for the next request of a persistent client."""

Frames = list[tuple[int, int]]


class ServiceLink:
    """The connection of one client.

    Args:
        loop: the node's loop.
        sock: connected, non-blocking.
        header: the client's connection header.
        first: bytes that came after the header.
        answer: ``answer(data, start, end, header)`` returns the bytes that answer a request; runs in a worker.
        submit: ``submit(job)`` runs a job in a worker, or returns why that is not possible.
        may_linger: whether a worker that has answered so many requests may wait a moment for more.
        on_closed: called once, with the link and the error, or None.
    """

    def __init__(
        self,
        loop: Loop,
        sock: socket.socket,
        header: dict[str, str],
        first: bytes,
        answer: Callable[[bytes, int, int, dict[str, str]], bytes],
        submit: Callable[[Callable[[], None]], str | None],
        may_linger: Callable[[int], bool],
        on_closed: Callable[[ServiceLink, Exception | None], None],
    ) -> None:
        self.header = header
        self._loop = loop
        self._sock = sock
        self._answer = answer
        self._submit = submit
        self._may_linger = may_linger
        self._on_closed = on_closed
        self._persistent = is_true(header.get("persistent"))
        self._buffer = FrameBuffer(4096, first=first)
        self._timer: TimerHandle | None = None
        self._patience = Patience(REQUEST_TIMEOUT)  # while there is a timer
        self._ending = False
        self._eager = Eager()

    def begin(self, greeting: bytes) -> None:
        """Send our header and wait for a request. On the loop."""
        try:
            if self._sock.send(greeting) < len(greeting):
                raise ProtocolError("it does not read its data")
            frames = self._buffer.received(0)
        except (OSError, ProtocolError) as error:
            self._close(error)
            return
        if frames:
            self._hand_over(frames)
        elif not self._may_linger(0) or self._submit(lambda: self._serve([])) is not None:
            self._wait()

    def end(self) -> None:
        """Close after the answer to the current call, if there is one. Any thread."""
        self._ending = True
        with contextlib.suppress(OSError):
            self._sock.shutdown(socket.SHUT_RD)  # wakes a thread that waits for a request

    # ---- waiting, on the loop

    def _wait(self) -> None:
        if self._ending:
            self._close(None)
            return
        self._sock.setblocking(False)
        self._loop.register(self._sock, READ, self._readable)
        if self._buffer.partial or not self._persistent:
            self._be_patient()

    def _be_patient(self) -> None:
        self._patience = Patience(REQUEST_TIMEOUT)
        self._timer = self._loop.call_later(REQUEST_TIMEOUT, self._late)

    def _late(self) -> None:
        left = self._patience.left()
        if left > 0:
            self._timer = self._loop.call_later(left, self._late)
            return
        self._loop.unregister(self._sock)
        begun = self._buffer.partial
        self._close(
            ProtocolError(f"the rest of its request did not arrive within {REQUEST_TIMEOUT:g} s") if begun else None
        )

    def _readable(self, _mask: int) -> None:
        fresh = not self._buffer.partial
        try:
            count = self._sock.recv_into(self._buffer.writable())
            if not count:
                self._stop_waiting()
                self._close(None)
                return
            frames = self._buffer.received(count)
            self._patience.moved(count)
        except BlockingIOError:
            return
        except (OSError, ProtocolError) as error:
            self._stop_waiting()
            self._close(error)
            return
        if frames:
            self._stop_waiting()
            self._hand_over(frames)
        elif fresh and self._timer is None:
            self._be_patient()

    def _stop_waiting(self) -> None:
        self._loop.unregister(self._sock)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _hand_over(self, frames: Frames) -> None:
        if self._ending:  # bytes after the end are read, too
            self._close(None)
            return
        refusal = self._submit(lambda: self._serve(frames))
        if refusal is not None:
            with contextlib.suppress(OSError):
                self._sock.send(encode_failure(refusal))
            self._close(ProtocolError(refusal))

    # ---- answering, in a worker

    def _serve(self, frames: Frames) -> None:
        sock, buffer, header = self._sock, self._buffer, self.header
        answered = 0
        try:
            bounded = bound_waits(sock, REQUEST_TIMEOUT, LINGER)
            while frames or (bounded and not buffer.partial and self._may_linger(answered)):
                frames = frames or self._linger()
                if not frames:
                    break
                data = buffer.take(frames)
                for start, end in frames:
                    sock.sendall(self._answer(data, start, end, header))
                    if not self._persistent or self._ending:
                        self._close(None)
                        return
                answered += len(frames)
                frames = []
        except WaitOver:
            self._close(ProtocolError(f"it did not read the rest of its response within {REQUEST_TIMEOUT:g} s"))
        except (OSError, ProtocolError) as error:
            self._close(error)
        else:
            self._loop.call_soon(self._wait)

    def _linger(self) -> Frames:
        """Return the requests that come within a moment; none if they are not whole by then.

        Raises:
            OSError: the client is gone, or this side ends.
        """
        try:
            count = self._eager.wait(self._receive)
        except WaitOver:
            return []
        if not count or self._ending:
            raise ConnectionError("closed")
        return self._buffer.received(count)

    def _receive(self, flags: int) -> int:
        return self._sock.recv_into(self._buffer.writable(), 0, flags)

    def _close(self, error: Exception | None) -> None:
        hang_up(self._sock)
        self._on_closed(self, error)
