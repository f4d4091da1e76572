"""The TCP links of a subscription: one (`TcpSource`) and all (`TcpLinks`)."""

from __future__ import annotations

import socket
import struct
import time
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

from pyros1.ground.errors import ProtocolError
from pyros1.msgs.large_arrays import SplitBody
from pyros1.net.socket_close import shutdown_and_close
from pyros1.net.spin_wait import DONTWAIT, POLLING_PAUSED, PollGuard, yield_processor
from pyros1.net.timeouts import set_socket_timeouts
from pyros1.node.subscribing.queues import Frames, Items
from pyros1.wire.framing import FrameBuffer

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from pyros1.node.subscribing.delivery_loop import DeliveryLoop
    from pyros1.node.subscribing.queues import Backlog, Batch
    from pyros1.node.subscribing.threads import Driver

MIN_LARGE_FRAME = 1 << 17
"""Minimum size in bytes of a large frame, and of an array in it that is received straight into its own memory instead
of being copied from the buffer."""
MAX_RESERVED = 16 << 20
"""Maximum size in bytes of an array whose memory is reserved in advance, unless an array at least half as large was
received before."""

RECEIVE_TIMEOUT = 0.02
"""Maximum number of seconds that `TcpSource.receive` waits if its argument ``wait`` is True."""
BUSY_POLL_TIME = 0.002
"""Seconds for which a link whose ``low_latency`` is True polls for the next message."""
_MSG_WAITALL = getattr(socket, "MSG_WAITALL", 0)
_unpack_u32 = struct.Struct("<I").unpack_from
DRAIN_TIME = 0.02
"""Maximum number of seconds spent on draining sockets before callbacks continue: a flood must not starve them."""

MAX_FLOOD_GAP = 30e-6
MAX_FLOOD_MESSAGES = 16
MAX_FLOOD_BYTES = 65536
"""A flood: MIN_FLOOD_STREAK receives in a row, of at most MAX_FLOOD_MESSAGES messages and MAX_FLOOD_BYTES bytes each,
less than MAX_FLOOD_GAP seconds apart.
"""
MIN_FLOOD_STREAK = 100
GATHER_TIME = 200e-6
"""Duration in seconds of the pause that lets messages accumulate during a flood."""


class ArrayLayout(NamedTuple):
    """Place of the array in the next large frame, if that frame is like the previous one.

    Attributes:
        begin: number of bytes before the array, including the length fields of frame and array.
        tail: number of bytes after the array.
        maximum: maximum size of the array in bytes.
        has_length_field: whether the array has a length field; otherwise the array is the whole frame.
    """

    begin: int
    tail: int
    maximum: int
    has_length_field: bool


class TcpSource:
    """A TCP link from a publisher, after the handshake.

    Attributes:
        header: the publisher's connection header.
        uri: URI of the publisher's slave API.
        address: the link's description for ``getBusInfo``.
        messages, bytes_received: number of messages and bytes received so far.
        connected: whether the link is open.
        can_wait: whether `receive` can wait for RECEIVE_TIMEOUT seconds; otherwise it never waits.
        last_readable_at: time at which the socket was last readable, in `perf_counter` seconds.
        expected_layout: the layout of the last large frame, which the next is likely to have; None if all frames go
            through the buffer.
        low_latency: whether a `receive` that waits polls for BUSY_POLL_TIME seconds before it sleeps. The system needs
            25 to 50 us to wake a sleeping thread; a polling thread occupies a processor meanwhile. On a busy machine,
            the thread sleeps, see `PollGuard`.
    """

    transport = "TCPROS"

    def __init__(self, sock: socket.socket, uri: str, header: dict[str, str], initial_bytes: bytes) -> None:
        self.sock = sock
        self.fd = sock.fileno()
        self.uri = uri
        self.header = header
        self.buffer = FrameBuffer(initial_bytes=initial_bytes)
        self.messages = 0
        self.bytes_received = len(initial_bytes)
        self.connected = True
        self.can_wait = _set_receive_timeout(sock)
        self.last_readable_at = 0.0
        self.expected_layout: ArrayLayout | None = None
        self.low_latency = False
        self._poll_guard = PollGuard()
        if sock.family == getattr(socket, "AF_UNIX", None):
            self._address = f"LOCAL connection on port 0 to [127.0.0.1:0 on socket {self.fd}]"
            return
        try:
            peer_address, port = sock.getpeername(), sock.getsockname()[1]
            self._address = (
                f"TCPROS connection on port {port} to [{peer_address[0]}:{peer_address[1]} on socket {self.fd}]"
            )
        except OSError:
            self._address = "TCPROS connection on port 0 to [unknown]"

    @property
    def address(self) -> str:
        return f"{self._address}, {POLLING_PAUSED}" if self._poll_guard.is_busy else self._address

    def receive(self, wait: bool = False) -> Batch | None:
        """Receive once from the socket.

        Args:
            wait: whether to wait up to RECEIVE_TIMEOUT seconds; only if `can_wait`.

        Returns:
            The messages that are complete now, if any; None at the end of the stream.

        Raises:
            BlockingIOError: no bytes have arrived.
            OSError: the connection is broken.
            ProtocolError: a frame is too large.
        """
        flags = 0 if wait else DONTWAIT
        if self.expected_layout is not None and not self.buffer.has_partial_frame:
            return self._receive_large(self.expected_layout, flags)
        count = self._poll_and_receive() if wait and self.low_latency else None
        if count is None:
            count = self.sock.recv_into(self.buffer.writable(), 0, flags)
        return self.take_received(count) if count else None

    def _poll_and_receive(self) -> int | None:
        """Poll for bytes; return how many arrived, or 0 at the end of the stream.

        Return None if the caller should use a blocking call instead, since nothing arrived within BUSY_POLL_TIME
        seconds, or since the machine is busy.
        """
        now = perf_counter()
        if not self._poll_guard.may_poll(now):
            return None
        free_space, receive, deadline = self.buffer.writable(), self.sock.recv_into, now + BUSY_POLL_TIME
        while now < deadline:
            try:
                return receive(free_space, 0, DONTWAIT)
            except BlockingIOError:
                yield_processor()  # the publisher may need this processor
            previous, now = now, perf_counter()
            if self._poll_guard.note_poll(previous, now):
                break
        return None

    def close(self) -> None:
        """Close the link's sockets."""
        shutdown_and_close(self.sock)

    def take_received(self, count: int) -> Batch:
        """Count bytes that were received into the buffer; return the messages that are complete now.

        Args:
            count: number of received bytes.

        Raises:
            ProtocolError: a frame is too large.
        """
        self.bytes_received += count
        frames = self.buffer.received(count)
        self.messages += len(frames)
        return self.batch(frames) if frames else Frames(self, b"", frames)

    def batch(self, frames: list[tuple[int, int]]) -> Batch:
        """Take complete frames out of the buffer and return them."""
        if frames[-1][1] > MIN_LARGE_FRAME and len(frames) == 1:  # a single body is not copied again
            return Items(self, self.buffer.take_bodies(frames))
        return Frames(self, self.buffer.take(frames), frames)

    def set_expected_layout(self, body_size: int, array_size: int, tail: int, has_length_field: bool) -> None:
        """Note where the array of a large frame is, for further frames of the same layout.

        Args:
            body_size: size of the frame's body in bytes.
            array_size: size of its array in bytes.
            tail: number of bytes after the array.
            has_length_field: whether the array has a length field.
        """
        begin = body_size - tail - array_size + 4
        if self.can_wait and _MSG_WAITALL and begin >= 4:
            self.expected_layout = ArrayLayout(begin, tail, max(MAX_RESERVED, 2 * array_size), has_length_field)

    def _receive_large(self, expected_layout: ArrayLayout, flags: int) -> Batch | None:
        """Receive a frame of the expected layout; all other bytes go to the buffer.

        The wait for the array is short, like that of any receive: the rest of a slow frame also goes to the buffer.
        """
        begin, tail, maximum, has_length_field = expected_layout
        received = self.sock.recv(begin, flags)
        if len(received) == begin:
            size, array_size = _unpack_u32(received, 0)[0], _unpack_u32(received, begin - 4)[0]
            if MIN_LARGE_FRAME <= array_size <= maximum and size + 4 == begin + array_size + tail:
                array = self._receive_rest(array_size)
                tail_bytes = self._receive_rest(tail) if len(array) == array_size else b""
                if len(array) == array_size and len(tail_bytes) == tail:
                    self.messages += 1
                    self.bytes_received += size + 4
                    return Items(self, [SplitBody(received[4:-4], array, tail_bytes, has_length_field)])
                received = b"".join((received, array, tail_bytes))
        self.expected_layout = None
        self.buffer.feed(received)
        return self.take_received(len(received)) if received else None

    def _receive_rest(self, size: int) -> bytes:
        if not size:
            return b""
        try:
            return self.sock.recv(size, _MSG_WAITALL)
        except BlockingIOError:
            return b""


def _set_receive_timeout(sock: socket.socket) -> bool:
    """Make receives wait in the kernel for at most RECEIVE_TIMEOUT seconds unless the flag DONTWAIT is passed; return
    False if the system does not support this, so that no receive waits.
    """
    if DONTWAIT and set_socket_timeouts(sock, RECEIVE_TIMEOUT):
        return True
    sock.setblocking(False)
    return False


class FloodDetector:
    """Detects a flood of single messages on a link while a thread keeps receiving from it.

    A publisher that sends each message separately wakes the receiver each time, which takes the publisher longer than
    sending. So the receiver lets messages accumulate for a moment.
    """

    def __init__(self, link: TcpSource) -> None:
        self._link = link
        self._streak = 0
        self._num_messages = link.messages
        self._num_bytes = link.bytes_received
        self._last_receive_at = perf_counter()

    def pause(self) -> None:
        """Pause after a receive if a flood of single messages is arriving."""
        link, now = self._link, perf_counter()
        count = link.messages - self._num_messages
        if (
            now - self._last_receive_at > count * MAX_FLOOD_GAP
            or link.bytes_received - self._num_bytes > MAX_FLOOD_BYTES
        ):
            self._streak = 0
        elif count <= MAX_FLOOD_MESSAGES:
            self._streak += 1
            if self._streak > MIN_FLOOD_STREAK:
                time.sleep(GATHER_TIME)
        self._num_messages, self._num_bytes, self._last_receive_at = link.messages, link.bytes_received, now


class TcpLinks:
    """The TCP links of a subscription. Only the owner of its delivery loop may use them.

    Args:
        delivery: the delivery loop, whose driver waits for the sockets.
        on_lost: called with (link, reason) when a link has ended; the reason is None for an orderly end.
    """

    def __init__(self, delivery: DeliveryLoop, on_lost: Callable[[TcpSource, str | None], None]) -> None:
        self._delivery = delivery
        self._on_lost = on_lost
        self._links: dict[int, TcpSource] = {}

    def __len__(self) -> int:
        return len(self._links)

    def __iter__(self) -> Iterator[TcpSource]:
        return iter(list(self._links.values()))

    def get(self, fd: int) -> TcpSource | None:
        """Return the link that uses a file descriptor; None if it has been closed."""
        return self._links.get(fd)

    def open(self, link: TcpSource) -> Batch | None:
        """Start waiting for a new link's socket; return the messages that arrived with its header, or None if the link
        is lost already.
        """
        driver = self._delivery.driver
        if driver.cooperative:
            link.can_wait = False
        self._links[link.fd] = link
        driver.register(link.fd, self._delivery)
        try:
            return link.take_received(0)
        except ProtocolError as error:
            self._lose(link, str(error))
            return None

    def rearm(self, link: TcpSource) -> None:
        """Wait for a link's socket again, unless the link is closed."""
        if self._links.get(link.fd) is link:
            self._delivery.driver.rearm(link.fd)

    def move(self, driver: Driver) -> None:
        """Move the links, and the delivery loop, to another driver."""
        for fd in self._links:
            self._delivery.driver.unregister(fd)
        self._delivery.driver = driver
        for fd in self._links:
            driver.register(fd, self._delivery)

    def close(self, link: TcpSource) -> None:
        """Close a link, without reporting it as lost."""
        if self._links.pop(link.fd, None) is not None:
            link.connected = False
            self._delivery.forget(link)
            self._delivery.driver.unregister(link.fd)
            link.close()

    def receive(self, link: TcpSource, wait: bool = False) -> Batch | None:
        """Receive once from a link; return None if nothing has arrived or the link is lost. See `TcpSource.receive`."""
        try:
            batch = link.receive(wait)
        except BlockingIOError:
            return None
        except OSError as error:
            self._lose(link, error.strerror or str(error))
            return None
        except ProtocolError as error:
            self._lose(link, str(error))
            return None
        if batch is None:
            self._lose(link, None)
        return batch

    def drain(self, backlog: Backlog) -> None:
        """Put the messages that have arrived on all links into a backlog."""
        for link in self:
            deadline = perf_counter() + DRAIN_TIME / (len(self) or 1)
            while perf_counter() < deadline and (batch := self.receive(link)) is not None:
                backlog.put_batch(batch)

    def _lose(self, link: TcpSource, reason: str | None) -> None:
        if link.fd in self._links:
            self.close(link)
            self._on_lost(link, reason)
