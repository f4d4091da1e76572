"""A publisher's link to a subscriber on the same machine; see `pyros1.wire.local`.

Small messages go through a Unix socket as over TCP. Of a large one goes a reference; `CREDIT` of them at most are out
at a time, so a slow subscriber keeps few blocks, and further references wait in the link's queue, the oldest of which
are dropped as always.
"""

from __future__ import annotations

import contextlib
import select
import selectors
import socket
import time
from collections.abc import Callable
from itertools import count, islice

from pyros1.net.loop import Loop
from pyros1.node.lane import Lane
from pyros1.node.publishing.pool import Place, Pool
from pyros1.node.publishing.tcp_link import PAUSE, TcpLink, WaitingLink
from pyros1.wire.header import encode_header
from pyros1.wire.local import (
    RECORD,
    TOKEN_SIZE,
    Reference,
    decode_done,
    encode_block,
    encode_reference,
)
from pyros1.wire.outqueue import Buffer, Frame, OutQueue

CREDIT = 8
"""Most references that a subscriber may have at a time."""
_AT_ONCE = 64
"""Most records that are read before other work goes on."""


class _Referring(bytes):
    """The frame of a reference.

    Attributes:
        number: of the reference.
    """

    number: int


class _Queue(OutQueue):
    """A queue that holds references back while the subscriber has enough of them.

    Args:
        limit: as for OutQueue.
        out: numbers of the references that are out, or wait here, with their blocks.
    """

    __slots__ = ("_out",)

    def __init__(self, limit: int | None, out: dict[int, int]) -> None:
        super().__init__(limit)
        self._out = out

    @property
    def credit(self) -> int:
        """How many references may be sent now."""
        waiting = sum(frame.__class__ is _Referring for frame in self._waiting)
        return CREDIT - len(self._out) + waiting

    def has(self, number: int) -> bool:
        """Return whether a reference waits."""
        return any(isinstance(frame, _Referring) and frame.number == number for frame in self._waiting)

    def push(self, frame: Frame) -> None:
        """Add a frame; drop the oldest waiting one if there are too many."""
        oldest = self._waiting[0] if self._waiting else None
        dropped = self.dropped
        super().push(frame)
        if self.dropped > dropped and isinstance(oldest, _Referring):
            self._out.pop(oldest.number, None)

    def buffers(self, most: int = 256) -> list[Buffer]:
        """Return what may be sent next."""
        if not self._out:
            return super().buffers(most)
        credit, parts = self.credit, list(self._begun)
        for frame in islice(self._waiting, max(0, most - len(parts))):
            if isinstance(frame, bytes):
                if frame.__class__ is _Referring:
                    credit -= 1
                    if credit < 0:
                        break
                parts.append(frame)
            else:
                parts.extend(frame)
                if len(parts) >= most:
                    break
        return parts


class SharedLink(TcpLink):
    """A link to a subscriber that shares memory with this process.

    Args:
        loop, lane, sock, header, queue_size, on_closed: as for TcpLink; the socket is a Unix socket.
        answer: the publisher's connection header, not encoded.
        pool: the topic's blocks.
        token: with which references begin.

    Raises:
        OSError: no further socket can be opened.
    """

    transport = "LOCAL"

    def __init__(
        self,
        loop: Loop,
        lane: Lane,
        sock: socket.socket,
        header: dict[str, str],
        answer: dict[str, str],
        queue_size: int | None,
        on_closed: Callable[[TcpLink], None],
        pool: Pool,
        token: bytes,
    ) -> None:
        assert len(token) == TOKEN_SIZE
        self._desk, self._their_desk = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._desk.setblocking(False)
        greeting = encode_header({**answer, "token": token.hex()})
        super().__init__(loop, lane, sock, header, greeting, queue_size, on_closed)
        self.out: dict[int, int] = {}  # block of each reference that is out or waits
        self._references = _Queue(queue_size, self.out)
        self._queue = self._references
        self._pool = pool
        self._token = token
        self._numbers = count(1)
        self._known: set[int] = set()  # blocks that the subscriber has
        self._watches_desk = False
        self._held = False  # references wait until the subscriber gives others back
        self._unsure: tuple[int, int] | None = None  # the reference that is being sent, and `bytes_sent` before

    def start(self) -> None:
        """Send the greeting, with the subscriber's end of the desk."""
        greeting, desk = self._greeting, self._their_desk
        try:
            sent = socket.send_fds(self._sock, [greeting], [desk.fileno()])
        except OSError:
            self._fail()
            return
        finally:
            desk.close()
        if sent < len(greeting):
            self._idle = False
            self._queue.push_begun(greeting, sent)
            self._block()

    def refer(self, place: Place) -> bool:
        """Send a reference to a large message. In the lane.

        Returns:
            Whether that was possible; otherwise the message must be sent whole.
        """
        if self._closed:
            return True
        self.take_back()
        if not self._introduce(place):
            return False
        number = next(self._numbers)
        frame = _Referring(encode_reference(self._token, Reference(number, place.block.number, *place[1:])))
        frame.number = number
        if self._references.credit <= 0:
            self._idle = False
        self._unsure = number, self.bytes_sent
        self.out[number] = place.block.number
        self.send(frame)
        self._unsure = None
        self.bytes_sent += place.size
        self._watch_if_held()
        return True

    def recover(self) -> None:
        """Recover as other links do; a reference that has not left counts as given back."""
        if self._unsure is not None:
            number, before = self._unsure
            begun = self.bytes_sent > before or (self._flying is not None and self._sent > 0)
            if not begun and not self._references.has(number):
                self.out.pop(number, None)
            self._unsure = None
        super().recover()

    def take_back(self) -> None:
        """Take note of the references that the subscriber has done with. In the lane."""
        if self._closed:
            return
        for _ in range(_AT_ONCE):
            try:
                record = self._desk.recv(RECORD)
            except BlockingIOError:
                return
            except OSError:
                record = b""
            if not record:
                self._fail()  # the subscriber is gone: no reference would come back
                return
            for number in decode_done(record):
                self.out.pop(number, None)
            if self._held:  # what waits for it must go, also if nothing more is published
                self._held = False
                self._loop.call_soon(self._lane.do, self._go_on)

    def _introduce(self, place: Place) -> bool:
        """Make sure that the subscriber has the block."""
        try:
            for number in self._known - self._pool.blocks.keys() - set(self.out.values()):
                self._desk.send(encode_block(number, 0))
                self._known.discard(number)
            block = place.block
            if block.fd < 0:
                return False  # a subscriber has just left with it
            if block.number not in self._known:
                socket.send_fds(self._desk, [encode_block(block.number, block.size)], [block.fd])
                self._known.add(block.number)
        except OSError:
            return False
        return True

    def _flush(self) -> None:
        super()._flush()
        self._watch_if_held()

    def _watch_if_held(self) -> None:
        """Wait for the subscriber if references must wait for it."""
        self._held = bool(self._queue) and not self._blocked and not self._closed
        if self._held:
            self._idle = False
            if not self._watches_desk:
                self._watches_desk = True
                self._loop.call_soon(self._watch_desk)

    # On the loop ------------------------------------------------------------------------------------------------------

    def _watch_desk(self) -> None:
        """Wait for records; for those that have come before, too: the system reports them as well."""
        if not self._closed:
            self._loop.register(self._desk, selectors.EVENT_READ, lambda _: self._desk_readable())

    def _desk_readable(self) -> None:
        self._loop_forgets_desk()
        self._lane.do(self._go_on)

    def _loop_forgets_desk(self) -> None:
        with contextlib.suppress(KeyError, ValueError, OSError):
            self._loop.unregister(self._desk)
        self._watches_desk = False

    def _go_on(self) -> None:
        self._held = False
        self.take_back()
        if not self._closed:
            self._flush()

    def _push_on(self) -> None:
        """Wait a little until the subscriber takes more, and send."""
        if not self._held:
            super()._push_on()
            return
        with contextlib.suppress(OSError, ValueError):  # the loop may close it meanwhile
            poller = select.poll()
            poller.register(self._desk, select.POLLIN)
            poller.poll(100)
        if self._lane.free:
            self._lane.do(self._go_on)
        else:
            time.sleep(PAUSE)  # the thread that works there sends

    def _fail(self) -> None:
        if not self._closed:
            super()._fail()
            self._pool.abandon(set(self.out.values()))
            self.out.clear()

    def _dispose(self) -> None:
        self._loop_forgets_desk()
        self._desk.close()
        self._their_desk.close()
        super()._dispose()


class WaitingSharedLink(SharedLink, WaitingLink):
    """A link whose publishers wait until all is sent."""

    def start(self) -> None:
        """Send the greeting; no publisher waits for it, or for the latched messages that follow it in this job."""
        super().start()
        self._loop.call_soon(self._lane.do, self._leave_to_loop)
