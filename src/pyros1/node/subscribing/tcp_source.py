"""The receiving end of a link from a publisher, over TCP."""

from __future__ import annotations

import socket
import struct
from collections import deque
from time import perf_counter
from typing import NamedTuple

from pyros1.msgs.large import SplitBody
from pyros1.net.closing import hang_up
from pyros1.net.eager import AT_ONCE, give_way
from pyros1.net.timeouts import bound_waits
from pyros1.wire.framing import FrameBuffer

LARGE = 1 << 17
"""Size in bytes from which a frame is received in pieces, its array straight into its final object."""
TRUSTED = 16 << 20
"""Largest array, in bytes, for which memory is reserved before it arrives, unless one half as large came before."""

PATIENCE = 0.02
"""Seconds that a patient `receive` waits."""
EAGERNESS = 0.002
"""Seconds that an eager link looks for the next message without sleeping."""
_ALL = getattr(socket, "MSG_WAITALL", 0)
_read_size = struct.Struct("<I").unpack_from


class Expected(NamedTuple):
    """Place of the array in the next large frame, if that is like the one before.

    Attributes:
        begin: bytes before the array, with the length fields of frame and array.
        tail: bytes after it.
        most: largest array that is accepted, in bytes.
        counted: whether the array has a length field; otherwise it is the whole frame.
    """

    begin: int
    tail: int
    most: int
    counted: bool


class TcpSource:
    """A TCP link from a publisher, past its handshake.

    Attributes:
        header: the publisher's connection header.
        uri: the publisher's slave API.
        messages, bytes_received: numbers so far.
        connected: whether the link is up.
        patient: whether `receive` can wait for PATIENCE seconds; otherwise it never waits.
        last_time: time at which the socket was last readable, in `perf_counter` seconds.
        expected: the shape of large frames, from the last one; None: all frames go through the buffer.
        eager: whether a patient `receive` looks for bytes for EAGERNESS seconds before it sleeps. The system needs
            25 to 50 us to wake a thread that sleeps; a thread that looks takes a processor meanwhile.
    """

    transport = "TCPROS"
    items: deque[bytes | SplitBody] | None = None
    """What came with the last receive, if not all of that is in the buffer; see `SharedSource`."""

    def __init__(self, sock: socket.socket, uri: str, header: dict[str, str], first: bytes) -> None:
        self.sock = sock
        self.fd = sock.fileno()
        self.uri = uri
        self.header = header
        self.buffer = FrameBuffer(first=first)
        self.messages = 0
        self.bytes_received = len(first)
        self.connected = True
        self.patient = _make_patient(sock)
        self.last_time = 0.0
        self.expected: Expected | None = None
        self.eager = False
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
            wait: whether to wait up to PATIENCE seconds, if the link is patient.

        Returns:
            The number of bytes that came into the buffer, 0 at the end of the stream; or a whole frame's body.

        Raises:
            BlockingIOError: no bytes have come.
            OSError: the connection is broken.
        """
        flags = 0 if wait else AT_ONCE
        if self.expected is not None and not self.buffer.partial:
            return self._receive_large(self.expected, flags)
        if wait and self.eager and (count := self._look()) is not None:
            return count
        return self.sock.recv_into(self.buffer.writable(), 0, flags)

    def _look(self) -> int | None:
        """Look again and again for bytes, and return as `receive` does; None after EAGERNESS seconds without any."""
        room, receive, until = self.buffer.writable(), self.sock.recv_into, perf_counter() + EAGERNESS
        while perf_counter() < until:
            try:
                return receive(room, 0, AT_ONCE)
            except BlockingIOError:
                give_way()  # the publisher may need this processor
        return None

    def close(self) -> None:
        """Close the link's sockets."""
        hang_up(self.sock)

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

    def expect(self, size: int, array: int, tail: int, counted: bool) -> None:
        """Note where the array of a large frame is, for frames of the same shape.

        Args:
            size: size of the frame's body in bytes.
            array: size of its array in bytes.
            tail: bytes after the array.
            counted: whether the array has a length field.
        """
        begin = size - tail - array + 4
        if self.patient and _ALL and begin >= 4:
            self.expected = Expected(begin, tail, max(TRUSTED, 2 * array), counted)

    def _receive_large(self, expected: Expected, flags: int) -> int | SplitBody:
        """Receive a frame of the expected shape; all other bytes go to the buffer.

        The wait for the array is short, like that of any receive: the rest of a slow frame goes to the buffer, too.
        """
        begin, tail, most, counted = expected
        got = self.sock.recv(begin, flags)
        if len(got) == begin:
            size, array = _read_size(got, 0)[0], _read_size(got, begin - 4)[0]
            if LARGE <= array <= most and size + 4 == begin + array + tail:
                data = self._receive_rest(array)
                end = self._receive_rest(tail) if len(data) == array else b""
                if len(data) == array and len(end) == tail:
                    self.messages += 1
                    self.bytes_received += size + 4
                    return SplitBody(got[4:-4], data, end, counted)
                got = b"".join((got, data, end))
        self.expected = None
        self.buffer.feed(got)
        return len(got)

    def _receive_rest(self, size: int) -> bytes:
        if not size:
            return b""
        try:
            return self.sock.recv(size, _ALL)
        except BlockingIOError:
            return b""


def _make_patient(sock: socket.socket) -> bool:
    """Let a plain receive wait in the kernel for a short time, if the system supports calls with and without a wait."""
    if AT_ONCE and bound_waits(sock, PATIENCE):
        return True
    sock.setblocking(False)
    return False
