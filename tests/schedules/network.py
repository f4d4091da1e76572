"""A stand-in for sockets: TCP connections within the test, whose waits a scheduler controls.

What matters of Linux is kept: sockets take no more than their buffer has room for, so that sends are partial;
descriptors are the lowest that are free, so that they are used again at once; a connection that is closed with unread
bytes in it is reset.
"""

from __future__ import annotations

import errno
import os
import socket
import struct
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, Protocol

from .scheduler import Scheduler

ROOM = 1 << 16
"""Bytes that wait in a connection, in each direction."""
FIRST_FD = 1000
FIRST_PORT = 40000
HOST = "127.0.0.1"

Buffer = bytes | bytearray | memoryview


def fault(number: int) -> OSError:
    """Return the error with that number."""
    return OSError(number, os.strerror(number))


class Watching(Protocol):
    """What watches descriptors: an epoll object."""

    watched: dict[int, int]


class Network:
    """The descriptors and ports of one run.

    Args:
        scheduler: the run.
        part: ``part(size)`` returns how much of what waits one receive gets.
        room: bytes that wait in a connection.
    """

    def __init__(self, scheduler: Scheduler, part: Callable[[int], int], room: int = ROOM) -> None:
        self.scheduler = scheduler
        self.part = part
        self.room = room
        self.files: dict[int, Socket | Watching] = {}
        self.listeners: dict[int, Socket] = {}
        self.datagrams: dict[int, Socket] = {}  # UDP sockets by port
        self.lost = 0  # datagrams
        self.epolls: list[Watching] = []
        self._last_port = FIRST_PORT

    def open(self, file: Socket | Watching) -> int:
        """Return a descriptor for a file."""
        number = FIRST_FD
        while number in self.files:
            number += 1
        self.files[number] = file
        return number

    def close(self, number: int) -> None:
        """Free a descriptor."""
        del self.files[number]
        for epoll in self.epolls:
            epoll.watched.pop(number, None)

    def new_port(self) -> int:
        """Return a port that was not used in this run."""
        self._last_port += 1
        return self._last_port

    def pair(self) -> tuple[Socket, Socket]:
        """Return two ends of a connection."""
        near, far = Socket(self), Socket(self)
        near.join(far)
        return near, far


class Socket:
    """As socket.socket, for TCP.

    Attributes:
        fd: its descriptor, -1 after the end.
        inbox: bytes that have come.
        other: the other end.
        port: its port.
        queue: connections to accept, if it listens.
        ended: whether the other end sends no more.
        broken: error of the connection, told once; or 0.
        family: as of a real one.
    """

    family = socket.AF_INET

    def __init__(self, network: Network) -> None:
        self._network = network
        self.fd = network.open(self)
        self._timeout: float | None = None
        self._kernel_timeouts: dict[int, float] = {}
        self.inbox = bytearray()
        self.other: Socket | None = None
        self.queue: deque[Socket] | None = None  # connections to accept
        self.port = 0
        self.ended = False  # the other end sends no more
        self._mute = False  # this end sends no more
        self.broken = 0  # error of the connection, told once

    # Setting up -------------------------------------------------------------------------------------------------------

    def join(self, other: Socket) -> None:
        """Connect two sockets."""
        self.other, other.other = other, self
        self.port = self.port or self._network.new_port()
        other.port = other.port or self._network.new_port()

    def fileno(self) -> int:
        """Return its descriptor, -1 after the end."""
        return self.fd

    def setblocking(self, flag: bool) -> None:
        """Let calls wait, or not."""
        self.settimeout(None if flag else 0.0)

    def settimeout(self, seconds: float | None) -> None:
        """Let calls wait so long."""
        self._check()
        self._timeout = seconds

    def gettimeout(self) -> float | None:
        """Return the seconds that calls wait."""
        return self._timeout

    def setsockopt(self, _level: int, option: int, value: int | bytes) -> None:
        """Note the timeouts that the system keeps; ignore all else."""
        self._check()
        if option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO) and isinstance(value, bytes):
            whole, part = struct.unpack("@ll", value)
            self._kernel_timeouts[option] = whole + part / 1e6

    def getsockopt(self, _level: int, _option: int) -> int:
        """Return the error of a connection."""
        number, self.broken = self.broken, 0
        return number

    def bind(self, address: tuple[str, int]) -> None:
        """Take a port."""
        self.port = address[1] or self._network.new_port()

    def listen(self, _backlog: int = 0) -> None:
        """Accept connections."""
        if self.port in self._network.listeners:
            raise fault(errno.EADDRINUSE)
        self.queue = deque()
        self._network.listeners[self.port] = self

    def accept(self) -> tuple[Socket, tuple[str, int]]:
        """Return the next connection."""
        waiting = self.queue
        assert waiting is not None
        self._until(lambda: waiting, self._timeout)
        sock = waiting.popleft()
        return sock, (HOST, sock.port)

    def connect(self, address: tuple[str, int]) -> None:
        """Connect to a port."""
        number = self.connect_ex(address)
        if number not in (0, errno.EINPROGRESS):
            raise fault(number)

    def connect_ex(self, address: tuple[str, int]) -> int:
        """Connect to a port; return the number of an error."""
        self._check()
        listener = self._network.listeners.get(address[1])
        if listener is None or listener.queue is None:
            return errno.ECONNREFUSED
        far = Socket(self._network)
        far.port = listener.port
        self.join(far)
        listener.queue.append(far)
        self._network.scheduler.point()
        return errno.EINPROGRESS if self._timeout == 0.0 else 0

    def getsockname(self) -> tuple[str, int]:
        """Return its address."""
        self._check()
        return (HOST, self.port)

    def getpeername(self) -> tuple[str, int]:
        """Return the address of the other end."""
        self._check()
        if self.other is None:
            raise fault(errno.ENOTCONN)
        return (HOST, self.other.port)

    # Receiving --------------------------------------------------------------------------------------------------------

    @property
    def readable(self) -> bool:
        """Whether a read does not wait."""
        if self.queue is not None:
            return bool(self.queue)
        return bool(self.inbox or self.ended or self.broken)

    def recv(self, size: int, flags: int = 0) -> bytes:
        """Receive bytes."""
        whole = bool(flags & socket.MSG_WAITALL)
        self._until(
            lambda: len(self.inbox) >= size or self.ended or self.broken if whole else self.readable,
            self._patience(socket.SO_RCVTIMEO, flags),
            short=whole and bool(self.inbox),
        )
        if self.inbox:
            count = min(size, len(self.inbox))
            if not whole:
                count = self._network.part(count)
            data = bytes(self.inbox[:count])
            del self.inbox[:count]
            return data
        if self.broken:
            number, self.broken, self.ended = self.broken, 0, True
            raise fault(number)
        return b""

    def recv_into(self, buffer: Any, size: int = 0, flags: int = 0) -> int:
        """Receive bytes into a buffer."""
        with memoryview(buffer).cast("B") as view:
            data = self.recv(size or len(view), flags)
            view[: len(data)] = data
        return len(data)

    # Sending ----------------------------------------------------------------------------------------------------------

    @property
    def writable(self) -> bool:
        """Whether a write does not wait."""
        other = self.other
        return self.queue is None and (
            bool(self._mute or self.broken) or other is None or other.fd < 0 or self._room > 0
        )

    @property
    def _room(self) -> int:
        return self._network.room - len(self.other.inbox) if self.other is not None else 0

    def send(self, data: Buffer, flags: int = 0) -> int:
        """Send as much as there is room for."""
        self._until(lambda: self.writable, self._patience(socket.SO_SNDTIMEO, flags))
        if self.broken:
            number, self.broken = self.broken, 0
            raise fault(number)
        other = self.other
        if other is None or self._mute or other.fd < 0:
            raise fault(errno.EPIPE)
        data = memoryview(data).cast("B")[: self._room]
        other.inbox += data
        return len(data)

    def sendmsg(self, buffers: Iterable[Buffer]) -> int:
        """Send as much of several buffers as there is room for."""
        return self.send(b"".join(buffers))

    def sendall(self, data: Buffer) -> None:
        """Send all."""
        view = memoryview(data).cast("B")
        while view:
            view = view[self.send(view) :]

    # The end ----------------------------------------------------------------------------------------------------------

    def shutdown(self, how: int) -> None:
        """End one direction, or both."""
        self._check()
        self._network.scheduler.point()
        if self.other is None:
            raise fault(errno.ENOTCONN)
        if how in (socket.SHUT_RD, socket.SHUT_RDWR):
            self.ended = True
        if how in (socket.SHUT_WR, socket.SHUT_RDWR):
            self._mute = True
            self.other.ended = True

    def close(self) -> None:
        """Close it; the other end is reset if bytes were not read."""
        if self.fd < 0:
            return
        number, self.fd = self.fd, -1
        self._network.close(number)
        if self.queue is not None:
            self._network.listeners.pop(self.port, None)
            for sock in self.queue:
                sock.break_off()
                sock.close()
        other = self.other
        if other is not None:
            other.ended = True
            if self.inbox and other.fd >= 0:
                other.broken = errno.ECONNRESET
        if not self._network.scheduler.over:
            self._network.scheduler.point()

    def break_off(self) -> None:
        """Reset the connection, as if a machine had gone."""
        if self.other is not None and self.other.fd >= 0:
            self.other.broken = errno.ECONNRESET
            self.other.ended = True
        if self.fd >= 0:
            self.broken = errno.ECONNRESET
            self.ended = True

    def __enter__(self) -> Socket:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # Waiting ----------------------------------------------------------------------------------------------------------

    def _check(self) -> None:
        if self.fd < 0:
            raise fault(errno.EBADF)

    def _patience(self, option: int, flags: int) -> float | None:
        if flags & socket.MSG_DONTWAIT:
            return 0.0
        if self._timeout is None:
            return -self._kernel_timeouts[option] if option in self._kernel_timeouts else None
        return self._timeout

    def _until(self, ready: Callable[[], object], timeout: float | None, short: bool = False) -> None:
        """Wait for a condition; a negative timeout is the system's, at whose end there is nothing to do."""
        self._check()
        if self._network.scheduler.wait(ready, None if timeout is None else abs(timeout)):
            self._check()
            return
        self._check()
        if short or self.inbox:
            return
        if timeout is not None and timeout > 0:
            raise TimeoutError("timed out")
        raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"the stand-in for sockets has no {name}")
