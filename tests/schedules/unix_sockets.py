"""Stand-ins for Unix sockets: streams, pairs whose records stay whole, and descriptors that come with them.

A descriptor of such a socket is one of the test's network; those of files, such as blocks of shared memory, are real.
"""

from __future__ import annotations

import errno
import os
import socket
from collections import deque
from collections.abc import Sequence

from .network import FIRST_FD, Buffer, Network, Socket, fault

RECORDS = 3
"""Records that wait in a socket."""


class UnixSocket(Socket):
    """As socket.socket, for streams between programs of one machine.

    Attributes:
        handed: descriptors that have come.
    """

    family = socket.AF_UNIX

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        self.handed: deque[Handed] = deque()

    def close(self) -> None:
        """Close it, and what has come and was not taken."""
        for handed in self.handed:
            drop(handed)
        self.handed.clear()
        super().close()


class RecordSocket(UnixSocket):
    """As one end of ``socketpair(AF_UNIX, SOCK_SEQPACKET)``.

    Attributes:
        waiting: records that have come, with their descriptors.
        copied: whether another descriptor of the same socket exists, so that its end is not the socket's.
    """

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        self.waiting: deque[tuple[bytes, Handed]] = deque()
        self.copied = False

    def copy(self) -> RecordSocket:
        """Return the same socket under a descriptor of its own, as one who receives it gets; this one can be closed."""
        made = RecordSocket(self._network)
        made.waiting, made.handed, made.ended, made.port = self.waiting, self.handed, self.ended, self.port
        made.other, self.copied = self.other, True
        assert made.other is not None
        made.other.other = made
        return made

    @property
    def readable(self) -> bool:
        """Whether a read does not wait."""
        return bool(self.waiting or self.ended or self.broken)

    @property
    def _room(self) -> int:
        return RECORDS - len(self.other.waiting) if isinstance(self.other, RecordSocket) else 0

    def recv(self, size: int, flags: int = 0) -> bytes:
        """Receive a record."""
        self._until(lambda: self.readable, self._patience(0, flags))
        if self.waiting:
            data, handed = self.waiting.popleft()
            self.handed.clear()
            self.handed.append(handed)
            return data[:size]
        if self.broken:
            number, self.broken, self.ended = self.broken, 0, True
            raise fault(number)
        return b""

    def send(self, data: Buffer, flags: int = 0) -> int:
        """Send a record."""
        self._until(lambda: self.writable, self._patience(0, flags))
        other = self.other
        if other is None or other.fd < 0 or not isinstance(other, RecordSocket):
            raise fault(errno.EPIPE)
        other.waiting.append((bytes(data), []))
        return len(data)

    def close(self) -> None:
        """Close it, or only this descriptor of it."""
        if self.fd < 0:
            return
        if self.copied:
            number, self.fd = self.fd, -1
            self._network.close(number)
            return
        for _, handed in self.waiting:
            drop(handed)
        if self.waiting and self.other is not None and self.other.fd >= 0:
            self.other.broken = errno.ECONNRESET
        super().close()


Handed = list[int | RecordSocket]


def drop(handed: Handed) -> None:
    """Close descriptors that nobody took."""
    for each in handed:
        if isinstance(each, int):
            os.close(each)
        else:
            each.close()


def send_fds(network: Network, sock: UnixSocket, buffers: Sequence[Buffer], descriptors: Sequence[int]) -> int:
    """As socket.send_fds."""
    handed: Handed = []
    for number in descriptors:
        file = network.files.get(number)
        handed.append(file.copy() if number >= FIRST_FD and isinstance(file, RecordSocket) else os.dup(number))
    other = sock.other
    try:
        sent = sock.send(b"".join(buffers))
    except OSError:
        drop(handed)
        raise
    assert isinstance(other, UnixSocket)
    if isinstance(other, RecordSocket):
        other.waiting[-1][1].extend(handed)
    else:
        other.handed.append(handed)
    return sent


def recv_fds(sock: UnixSocket, size: int, _most: int) -> tuple[bytes, list[int], int, None]:
    """As socket.recv_fds."""
    data = sock.recv(size)
    handed = sock.handed.popleft() if sock.handed else []
    return data, [each if isinstance(each, int) else each.fileno() for each in handed], 0, None


def pair(network: Network, kind: type[UnixSocket]) -> tuple[UnixSocket, UnixSocket]:
    """Return two ends of a connection."""
    near, far = kind(network), kind(network)
    near.join(far)
    return near, far
