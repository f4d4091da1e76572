"""The receiving end of a link from a publisher, over TCP."""

from __future__ import annotations

import socket
import struct
from collections import deque
from time import perf_counter
from typing import NamedTuple

from pyros1.msgs.large_arrays import SplitBody
from pyros1.net.socket_close import shutdown_and_close
from pyros1.net.spin_wait import DONTWAIT, yield_processor
from pyros1.net.timeouts import set_socket_timeouts
from pyros1.wire.framing import FrameBuffer

MIN_LARGE_FRAME = 1 << 17
"""Size in bytes from which a frame is received in pieces, its array directly into the final object."""
MAX_RESERVED = 16 << 20
"""Maximum size, in bytes, of an array whose memory is reserved in advance, unless one half as large came before."""

RECEIVE_TIMEOUT = 0.02
"""Seconds that a patient `receive` waits."""
SPIN_TIME = 0.002
"""Seconds that an eager link looks for the next message without sleeping."""
_ALL = getattr(socket, "MSG_WAITALL", 0)
_read_size = struct.Struct("<I").unpack_from


class ArrayLayout(NamedTuple):
    """Place of the array in the next large frame, if that is like the one before.

    Attributes:
        begin: bytes before the array, with the length fields of frame and array.
        tail: bytes after it.
        maximum: largest array that is accepted, in bytes.
        has_length_field: whether the array has a length field; otherwise it is the whole frame.
    """

    begin: int
    tail: int
    maximum: int
    has_length_field: bool


class TcpSource:
    """A TCP link from a publisher, past its handshake.

    Attributes:
        header: the publisher's connection header.
        uri: the publisher's slave API.
        messages, bytes_received: numbers so far.
        connected: whether the link is up.
        can_wait: whether `receive` can wait for RECEIVE_TIMEOUT seconds; otherwise it never waits.
        last_time: time at which the socket was last readable, in `perf_counter` seconds.
        expected: the shape of large frames, from the last one; None: all frames go through the buffer.
        spins: whether a patient `receive` looks for bytes for SPIN_TIME seconds before it sleeps. The system needs
            25 to 50 us to wake a sleeping thread; a polling thread occupies a processor meanwhile.
    """

    transport = "TCPROS"
    items: deque[bytes | SplitBody] | None = None
    """The messages of the last receive, if they are not all in the buffer; see `SharedSource`."""

    def __init__(self, sock: socket.socket, uri: str, header: dict[str, str], first: bytes) -> None:
        self.sock = sock
        self.fd = sock.fileno()
        self.uri = uri
        self.header = header
        self.buffer = FrameBuffer(first=first)
        self.messages = 0
        self.bytes_received = len(first)
        self.connected = True
        self.can_wait = _set_receive_timeout(sock)
        self.last_time = 0.0
        self.expected: ArrayLayout | None = None
        self.spins = False
        if sock.family == getattr(socket, "AF_UNIX", None):
            self.address = f"LOCAL connection on port 0 to [127.0.0.1:0 on socket {self.fd}]"
            return
        try:
            peer, port = sock.getpeername(), sock.getsockname()[1]
            self.address = f"TCPROS connection on port {port} to [{peer[0]}:{peer[1]} on socket {self.fd}]"
        except OSError:
            self.address = "TCPROS connection on port 0 to [unknown]"

    def receive(self, wait: bool = False) -> int | SplitBody:
        """Receive into the buffer, or a large frame in pieces.

        Args:
            wait: whether to wait up to RECEIVE_TIMEOUT seconds, if the link is patient.

        Returns:
            The number of bytes that came into the buffer, 0 at the end of the stream; or a whole frame's body.

        Raises:
            BlockingIOError: no bytes have come.
            OSError: the connection is broken.
        """
        flags = 0 if wait else DONTWAIT
        if self.expected is not None and not self.buffer.partial:
            return self._receive_large(self.expected, flags)
        if wait and self.spins and (count := self._spin_receive()) is not None:
            return count
        return self.sock.recv_into(self.buffer.writable(), 0, flags)

    def _spin_receive(self) -> int | None:
        """Poll for bytes, and return like `receive`; None after SPIN_TIME seconds without any."""
        free_space, receive, deadline = self.buffer.writable(), self.sock.recv_into, perf_counter() + SPIN_TIME
        while perf_counter() < deadline:
            try:
                return receive(free_space, 0, DONTWAIT)
            except BlockingIOError:
                yield_processor()  # the publisher may need this processor
        return None

    def close(self) -> None:
        """Close the link's sockets."""
        shutdown_and_close(self.sock)

    def split(self, count: int) -> list[tuple[int, int]]:
        """Count the bytes that came into the buffer, and return (start, end) of its complete frames.

        Args:
            count: number of bytes.

        Raises:
            ProtocolError: a frame is too large.
        """
        self.bytes_received += count
        frames = self.buffer.received(count)
        self.messages += len(frames)
        return frames

    def expect(self, size: int, array: int, tail: int, has_length_field: bool) -> None:
        """Note where the array of a large frame is, for frames of the same shape.

        Args:
            size: size of the frame's body in bytes.
            array: size of its array in bytes.
            tail: bytes after the array.
            has_length_field: whether the array has a length field.
        """
        begin = size - tail - array + 4
        if self.can_wait and _ALL and begin >= 4:
            self.expected = ArrayLayout(begin, tail, max(MAX_RESERVED, 2 * array), has_length_field)

    def _receive_large(self, expected: ArrayLayout, flags: int) -> int | SplitBody:
        """Receive a frame of the expected shape; all other bytes go to the buffer.

        The wait for the array is short, like that of any receive: the rest of a slow frame also goes to the buffer.
        """
        begin, tail, maximum, has_length_field = expected
        received = self.sock.recv(begin, flags)
        if len(received) == begin:
            size, array = _read_size(received, 0)[0], _read_size(received, begin - 4)[0]
            if MIN_LARGE_FRAME <= array <= maximum and size + 4 == begin + array + tail:
                data = self._receive_rest(array)
                end = self._receive_rest(tail) if len(data) == array else b""
                if len(data) == array and len(end) == tail:
                    self.messages += 1
                    self.bytes_received += size + 4
                    return SplitBody(received[4:-4], data, end, has_length_field)
                received = b"".join((received, data, end))
        self.expected = None
        self.buffer.feed(received)
        return len(received)

    def _receive_rest(self, size: int) -> bytes:
        if not size:
            return b""
        try:
            return self.sock.recv(size, _ALL)
        except BlockingIOError:
            return b""


def _set_receive_timeout(sock: socket.socket) -> bool:
    """Let a plain receive wait in the kernel for a short time, if the system supports calls with and without a wait."""
    if DONTWAIT and set_socket_timeouts(sock, RECEIVE_TIMEOUT):
        return True
    sock.setblocking(False)
    return False
