"""A publisher's link to a subscriber on the same machine; see `pyros1.wire.local`.

Small messages are sent through a Unix socket, as they would be over TCP. A large message is written to shared memory,
and only a reference to it is sent. At most `MAX_REFERENCES` are outstanding at a time, so a slow subscriber occupies
few blocks. Further references wait in the link's queue, which drops the oldest as usual.
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
from pyros1.node.publishing.block_pool import BlockPool, Placement
from pyros1.node.publishing.tcp_link import POLL_DELAY, TcpLink, WaitingLink
from pyros1.node.strand import Strand
from pyros1.wire.header import encode_header
from pyros1.wire.local import (
    MAX_RECORD_SIZE,
    TOKEN_SIZE,
    Reference,
    decode_releases,
    encode_block,
    encode_reference,
)
from pyros1.wire.outqueue import Buffer, Frame, OutQueue

MAX_REFERENCES = 8
"""Maximum number of references that a subscriber may hold at a time."""
_MAX_RECORDS_PER_TURN = 64
"""Maximum number of records to read before other work continues."""


class _ReferenceFrame(bytes):
    """A frame that contains a reference to a message in shared memory.

    Attributes:
        number: the reference's number.
    """

    number: int


class _ReferenceQueue(OutQueue):
    """A queue that does not send further references while the subscriber holds `MAX_REFERENCES` of them.

    Args:
        limit: as for OutQueue.
        outstanding: number of each reference that was sent or is queued here -> number of its block.
    """

    __slots__ = ("_outstanding",)

    def __init__(self, limit: int | None, outstanding: dict[int, int]) -> None:
        super().__init__(limit)
        self._outstanding = outstanding

    @property
    def num_available(self) -> int:
        """The number of references that may be sent now."""
        waiting = sum(frame.__class__ is _ReferenceFrame for frame in self._waiting)
        return MAX_REFERENCES - len(self._outstanding) + waiting

    def has_reference(self, number: int) -> bool:
        """Return whether a reference is queued."""
        return any(isinstance(frame, _ReferenceFrame) and frame.number == number for frame in self._waiting)

    def push(self, frame: Frame) -> None:
        """Add a frame; drop the oldest queued one if there are too many."""
        oldest = self._waiting[0] if self._waiting else None
        dropped_before = self.dropped
        super().push(frame)
        if self.dropped > dropped_before and isinstance(oldest, _ReferenceFrame):
            self._outstanding.pop(oldest.number, None)

    def buffers(self, max_buffers: int = 256) -> list[Buffer]:
        """Return the frames that may be sent next."""
        if not self._outstanding:
            return super().buffers(max_buffers)
        num_available, parts = self.num_available, list(self._partial)
        for frame in islice(self._waiting, max(0, max_buffers - len(parts))):
            if isinstance(frame, bytes):
                if frame.__class__ is _ReferenceFrame:
                    num_available -= 1
                    if num_available < 0:
                        break
                parts.append(frame)
            else:
                parts.extend(frame)
                if len(parts) >= max_buffers:
                    break
        return parts


class SharedLink(TcpLink):
    """A link to a subscriber that shares memory with this process.

    Args:
        loop, strand, sock, header, queue_size, on_closed: as for TcpLink; the socket is a Unix socket.
        response: the publisher's connection header, not encoded.
        pool: the topic's blocks.
        token: the first bytes of each reference.

    Raises:
        OSError: no more sockets can be opened.
    """

    transport = "LOCAL"

    def __init__(
        self,
        loop: Loop,
        strand: Strand,
        sock: socket.socket,
        header: dict[str, str],
        response: dict[str, str],
        queue_size: int | None,
        on_closed: Callable[[TcpLink], None],
        pool: BlockPool,
        token: bytes,
    ) -> None:
        assert len(token) == TOKEN_SIZE
        self._control_socket, self._peer_control_socket = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._control_socket.setblocking(False)
        encoded_header = encode_header({**response, "token": token.hex()})
        super().__init__(loop, strand, sock, header, encoded_header, queue_size, on_closed)
        self.outstanding: dict[int, int] = {}  # number of a reference that was sent or is queued -> number of its block
        self._reference_queue = _ReferenceQueue(queue_size, self.outstanding)
        self._queue = self._reference_queue
        self._pool = pool
        self._token = token
        self._reference_numbers = count(1)
        self._sent_blocks: set[int] = set()  # numbers of the blocks that the subscriber has received
        self._watches_control_socket = False
        self._has_waiting_references = False  # whether references wait until the subscriber releases others
        self._reference_in_progress: tuple[int, int] | None = (
            None  # number of the reference being sent, and `bytes_sent` before it
        )

    def start(self) -> None:
        """Send the connection header and the subscriber's end of the control socket."""
        encoded_header, control_socket = self._encoded_header, self._peer_control_socket
        try:
            sent = socket.send_fds(self._sock, [encoded_header], [control_socket.fileno()])
        except OSError:
            self._fail()
            return
        finally:
            control_socket.close()
        if sent < len(encoded_header):
            self._is_idle = False
            self._queue.push_partial(encoded_header, sent)
            self._block()

    def send_reference(self, placement: Placement) -> bool:
        """Send a reference to a large message. Called in the strand.

        Returns:
            False if the message itself must be sent instead, since the reference could not be sent.
        """
        if self._closed:
            return True
        self.receive_releases()
        if not self._announce_block(placement):
            return False
        number = next(self._reference_numbers)
        frame = _ReferenceFrame(
            encode_reference(self._token, Reference(number, placement.block.number, *placement[1:]))
        )
        frame.number = number
        if self._reference_queue.num_available <= 0:
            self._is_idle = False
        self._reference_in_progress = number, self.bytes_sent
        self.outstanding[number] = placement.block.number
        self.send(frame)
        self._reference_in_progress = None
        self.bytes_sent += placement.size
        self._watch_if_references_wait()
        return True

    def recover(self) -> None:
        """Recover like `TcpLink.recover`; a reference that has not been sent is considered released."""
        if self._reference_in_progress is not None:
            number, bytes_before = self._reference_in_progress
            is_partly_sent = self.bytes_sent > bytes_before or (
                self._frame_in_flight is not None and self._sent_bytes > 0
            )
            if not is_partly_sent and not self._reference_queue.has_reference(number):
                self.outstanding.pop(number, None)
            self._reference_in_progress = None
        super().recover()

    def receive_releases(self) -> None:
        """Process the references that the subscriber has released. Called in the strand."""
        if self._closed:
            return
        for _ in range(_MAX_RECORDS_PER_TURN):
            try:
                record = self._control_socket.recv(MAX_RECORD_SIZE)
            except BlockingIOError:
                return
            except OSError:
                record = b""
            if not record:
                self._fail()  # the subscriber is gone and will not release its references
                return
            for number in decode_releases(record):
                self.outstanding.pop(number, None)
            if self._has_waiting_references:  # send them even if nothing more is published
                self._has_waiting_references = False
                self._loop.call_soon(self._strand.do, self._resume)

    def _announce_block(self, placement: Placement) -> bool:
        """Send a block to the subscriber, unless it already has the block; return False if that is not possible."""
        try:
            for number in self._sent_blocks - self._pool.blocks.keys() - set(self.outstanding.values()):
                self._control_socket.send(encode_block(number, 0))
                self._sent_blocks.discard(number)
            block = placement.block
            if block.fd < 0:
                return False  # a subscriber has just disconnected while using the block
            if block.number not in self._sent_blocks:
                socket.send_fds(self._control_socket, [encode_block(block.number, block.size)], [block.fd])
                self._sent_blocks.add(block.number)
        except OSError:
            return False
        return True

    def _flush(self) -> None:
        super()._flush()
        self._watch_if_references_wait()

    def _watch_if_references_wait(self) -> None:
        """If references are queued, let the loop wait until the subscriber releases others."""
        self._has_waiting_references = bool(self._queue) and not self._is_blocked and not self._closed
        if self._has_waiting_references:
            self._is_idle = False
            if not self._watches_control_socket:
                self._watches_control_socket = True
                self._loop.call_soon(self._watch_control_socket)

    # On the loop ------------------------------------------------------------------------------------------------------

    def _watch_control_socket(self) -> None:
        """Wait for records; the system also reports those that have already arrived."""
        if not self._closed:
            self._loop.register(
                self._control_socket, selectors.EVENT_READ, lambda _: self._on_control_socket_readable()
            )

    def _on_control_socket_readable(self) -> None:
        self._unwatch_control_socket()
        self._strand.do(self._resume)

    def _unwatch_control_socket(self) -> None:
        with contextlib.suppress(KeyError, ValueError, OSError):
            self._loop.unregister(self._control_socket)
        self._watches_control_socket = False

    def _resume(self) -> None:
        self._has_waiting_references = False
        self.receive_releases()
        if not self._closed:
            self._flush()

    def _wait_and_send(self) -> None:
        """Wait briefly until the subscriber accepts more, then send."""
        if not self._has_waiting_references:
            super()._wait_and_send()
            return
        with contextlib.suppress(OSError, ValueError):  # the loop may close the socket meanwhile
            poller = select.poll()
            poller.register(self._control_socket, select.POLLIN)
            poller.poll(100)
        if self._strand.free:
            self._strand.do(self._resume)
        else:
            time.sleep(POLL_DELAY)  # the thread that is running the strand's jobs will send

    def _fail(self) -> None:
        if not self._closed:
            super()._fail()
            self._pool.retire(set(self.outstanding.values()))
            self.outstanding.clear()

    def _dispose(self) -> None:
        self._unwatch_control_socket()
        self._control_socket.close()
        self._peer_control_socket.close()
        super()._dispose()


class WaitingSharedLink(SharedLink, WaitingLink):
    """A link through shared memory whose publishers wait until everything is sent."""

    def start(self) -> None:
        """Start sending the connection header; the loop sends the rest of it, and the latched messages that follow."""
        super().start()
        self._loop.call_soon(self._strand.do, self._let_loop_send)
