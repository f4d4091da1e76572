"""A connection's transport to which any thread may write while no earlier bytes are waiting to be sent.

A message that arrives in another thread can thus be sent from there. Passing it to the event loop would take longer
than everything else: the loop must be woken, and the threads then compete for the interpreter's lock.

A thread sends only while the operating system has accepted everything written so far (CLEAR), and all bytes of one
write are sent before the next write. Bytes that the system does not accept wait for the event loop; while any are
waiting, only the loop writes, in order. The lock is held during each write and while the socket is closed, so frames
cannot be interleaved or written to a closed socket.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable, Iterable, Sequence
from enum import Enum, auto
from typing import Any

Piece = bytes | bytearray | memoryview
_MAX_PIECES = 64
"""Maximum number of pieces that are passed to the system together, far below its limit."""


class _State(Enum):
    """Where unsent bytes are, and so who may write.

    ::

        LOOP_ONLY  the loop shares the transport                     -> CLEAR or BUFFERED
        CLEAR      a thread sends more than the system accepts       -> PARTIAL
        CLEAR      the loop writes more than the system accepts      -> BUFFERED
        PARTIAL    the loop takes over the rest                      -> BUFFERED, or CLEAR if the system accepts it
        BUFFERED   the loop finds its transport's buffer empty       -> CLEAR
        any        the loop closes the connection, or has lost it    -> LOOP_ONLY
    """

    LOOP_ONLY = auto()  # threads may not send
    CLEAR = auto()  # the system has accepted everything
    PARTIAL = auto()  # a thread's unsent bytes wait for the loop
    BUFFERED = auto()  # unsent bytes are in the buffer of the loop's transport


class SharedTransport(asyncio.Transport):
    """An event loop's transport to which other threads may write, too. `send` is the only method that they may call.

    Args:
        transport: the loop's transport.
        loop: the loop.
        may_send: returns whether threads may send; called by any thread.

    Attributes:
        lock: held during each write, and while the socket is closed.
        socket: a duplicate of the connection's socket, for threads; None while they may not send.
    """

    def __init__(
        self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop, may_send: Callable[[], bool]
    ) -> None:
        super().__init__()
        self._transport = transport
        self._loop = loop
        self._may_send = may_send
        self.lock = threading.Lock()
        self._state = _State.LOOP_ONLY
        self._rest: list[Piece] = []
        # A separate descriptor: the loop may close its own, whose number may then be reused while a thread still
        # writes.
        self.socket: socket.socket | None = None

    def send(self, pieces: Sequence[Piece]) -> bool:
        """Send bytes without waiting, from any thread.

        Args:
            pieces: whole frames, in one or several pieces. They must not be changed afterwards.

        Returns:
            Whether all bytes have been sent, or will be sent before anything else. If not, none has been sent.
        """
        with self.lock:
            if self._state is not _State.CLEAR or not self._may_send():
                return False
            rest = self._pass_to_system(pieces)
            if rest is pieces:
                return False
            if not rest:
                return True
            self._rest, self._state = list(rest), _State.PARTIAL
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self.writelines, ())
        return True

    def _pass_to_system(self, pieces: Sequence[Piece]) -> Sequence[Piece]:
        """Send pieces; return what the system has not accepted: ``pieces`` itself if it has accepted nothing."""
        assert self.socket is not None
        try:
            sent = self.socket.send(pieces[0]) if len(pieces) == 1 else self.socket.sendmsg(pieces[:_MAX_PIECES])
        except OSError:  # the system's buffer is full; or the connection is broken, which the loop notices
            return pieces
        for number, piece in enumerate(pieces):
            if sent < len(piece):
                return (memoryview(piece)[sent:], *pieces[number + 1 :])
            sent -= len(piece)
        return ()

    # For the loop's thread only ---------------------------------------------------------------------------------------

    def share(self) -> None:
        """Let threads send from now on, unless the connection is encrypted or the system cannot send several pieces."""
        if self.socket is not None or self.is_closing() or self.get_extra_info("ssl_object") is not None:
            return
        try:
            duplicate = self.get_extra_info("socket").dup()
        except (AttributeError, OSError):  # no socket, or too many open files
            return
        if not hasattr(duplicate, "sendmsg"):
            duplicate.close()
            return
        with self.lock:
            self.socket, self._state = duplicate, _State.CLEAR
            self._update_state()

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Write after everything that is still unsent."""
        self.writelines((data,))

    def writelines(self, list_of_data: Iterable[Any]) -> None:
        """Write pieces, with nothing in between, after everything that is still unsent."""
        pieces: Sequence[Piece] = [piece for piece in list_of_data if piece]
        with self.lock:
            self._pass_rest_on()
            if pieces and self._state is _State.CLEAR:
                pieces = self._pass_to_system(pieces)
            for piece in pieces:
                self._transport.write(piece)
            self._update_state()

    def _pass_rest_on(self) -> None:
        """Let the loop's transport send what a thread could not."""
        rest, self._rest = self._rest, []
        for piece in rest:
            self._transport.write(piece)

    def _update_state(self) -> None:
        if self._state is not _State.LOOP_ONLY:
            self._state = _State.BUFFERED if self._transport.get_write_buffer_size() else _State.CLEAR

    def get_write_buffer_size(self) -> int:
        """Return the number of unsent bytes."""
        with self.lock:
            if not self._rest:
                self._update_state()
            return sum(map(len, self._rest)) + self._transport.get_write_buffer_size()

    def write_eof(self) -> None:
        """Shut down writing after all unsent bytes have been sent."""
        self._close(self._transport.write_eof)

    def close(self) -> None:
        """Close the connection after all unsent bytes have been sent."""
        self._close(self._transport.close)

    def abort(self) -> None:
        """Close the connection immediately."""
        with self.lock:
            self._rest = []
        self._close(self._transport.abort)

    def _close(self, close: Callable[[], None]) -> None:
        with self.lock:
            self._pass_rest_on()
            self._state = _State.LOOP_ONLY
        close()

    def lose(self) -> None:
        """Stop sending, since the connection has ended. Must be called before its socket is closed."""
        with self.lock:
            self._state, self._rest = _State.LOOP_ONLY, []
            if self.socket is not None:
                self.socket.close()
                self.socket = None

    # Passed on to the loop's transport --------------------------------------------------------------------------------

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        """Return a property of the connection."""
        return self._transport.get_extra_info(name, default)

    def is_closing(self) -> bool:
        """Return whether the connection is being closed."""
        return self._transport.is_closing()

    def can_write_eof(self) -> bool:
        """Return whether `write_eof` may be called."""
        return self._transport.can_write_eof()

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        """Set the numbers of unsent bytes at which writing is paused and resumed."""
        self._transport.set_write_buffer_limits(high, low)

    def is_reading(self) -> bool:
        """Return whether the transport is reading."""
        return self._transport.is_reading()

    def pause_reading(self) -> None:
        """Stop reading."""
        self._transport.pause_reading()

    def resume_reading(self) -> None:
        """Resume reading."""
        self._transport.resume_reading()
