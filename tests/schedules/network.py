"""A stand-in for the module `socket`: TCP connections within the test, whose waits a scheduler controls.

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
        self.epolls: list[Watching] = []
        self._port = FIRST_PORT

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
        self._port += 1
        return self._port

    def pair(self) -> tuple[Socket, Socket]:
        """Return two ends of a connection."""
        near, far = Socket(self), Socket(self)
        near.join(far)
        return near, far


class Socket:
    """As socket.socket, for TCP."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._fd = network.open(self)
        self._timeout: float | None = None
        self._kernel_timeouts: dict[int, float] = {}
        self._inbox = bytearray()
        self._other: Socket | None = None
        self._waiting: deque[Socket] | None = None  # connections to accept
        self._port = 0
        self._ended = False  # the other end sends no more
        self._mute = False  # this end sends no more
        self._broken = 0  # error of the connection, told once

    # Setting up -------------------------------------------------------------------------------------------------------

    def join(self, other: Socket) -> None:
        """Connect two sockets."""
        self._other, other._other = other, self
        self._port = self._port or self._network.new_port()
        other._port = other._port or self._network.new_port()

    def fileno(self) -> int:
        """Return its descriptor, -1 after the end."""
        return self._fd

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
        number, self._broken = self._broken, 0
        return number

    def bind(self, address: tuple[str, int]) -> None:
        """Take a port."""
        self._port = address[1] or self._network.new_port()

    def listen(self, _backlog: int = 0) -> None:
        """Accept connections."""
        if self._port in self._network.listeners:
            raise fault(errno.EADDRINUSE)
        self._waiting = deque()
        self._network.listeners[self._port] = self

    def accept(self) -> tuple[Socket, tuple[str, int]]:
        """Return the next connection."""
        waiting = self._waiting
        assert waiting is not None
        self._until(lambda: waiting, self._timeout)
        sock = waiting.popleft()
        return sock, (HOST, sock._port)

    def connect(self, address: tuple[str, int]) -> None:
        """Connect to a port."""
        number = self.connect_ex(address)
        if number not in (0, errno.EINPROGRESS):
            raise fault(number)

    def connect_ex(self, address: tuple[str, int]) -> int:
        """Connect to a port; return the number of an error."""
        self._check()
        listener = self._network.listeners.get(address[1])
        if listener is None or listener._waiting is None:
            return errno.ECONNREFUSED
        far = Socket(self._network)
        far._port = listener._port
        self.join(far)
        listener._waiting.append(far)
        self._network.scheduler.point()
        return errno.EINPROGRESS if self._timeout == 0.0 else 0

    def getsockname(self) -> tuple[str, int]:
        """Return its address."""
        self._check()
        return (HOST, self._port)

    def getpeername(self) -> tuple[str, int]:
        """Return the address of the other end."""
        self._check()
        if self._other is None:
            raise fault(errno.ENOTCONN)
        return (HOST, self._other._port)

    # Receiving --------------------------------------------------------------------------------------------------------

    @property
    def readable(self) -> bool:
        """Whether a read does not wait."""
        if self._waiting is not None:
            return bool(self._waiting)
        return bool(self._inbox or self._ended or self._broken)

    def recv(self, size: int, flags: int = 0) -> bytes:
        """Receive bytes."""
        whole = bool(flags & socket.MSG_WAITALL)
        self._until(
            lambda: len(self._inbox) >= size or self._ended or self._broken if whole else self.readable,
            self._patience(socket.SO_RCVTIMEO, flags),
            short=whole and bool(self._inbox),
        )
        if self._inbox:
            count = min(size, len(self._inbox))
            if not whole:
                count = self._network.part(count)
            data = bytes(self._inbox[:count])
            del self._inbox[:count]
            return data
        if self._broken:
            number, self._broken, self._ended = self._broken, 0, True
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
        other = self._other
        return self._waiting is None and (
            bool(self._mute or self._broken) or other is None or other._fd < 0 or self._room > 0
        )

    @property
    def _room(self) -> int:
        return self._network.room - len(self._other._inbox) if self._other is not None else 0

    def send(self, data: Buffer, flags: int = 0) -> int:
        """Send as much as there is room for."""
        self._until(lambda: self.writable, self._patience(socket.SO_SNDTIMEO, flags))
        if self._broken:
            number, self._broken = self._broken, 0
            raise fault(number)
        other = self._other
        if other is None or self._mute or other._fd < 0:
            raise fault(errno.EPIPE)
        data = memoryview(data).cast("B")[: self._room]
        other._inbox += data
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
        if self._other is None:
            raise fault(errno.ENOTCONN)
        if how in (socket.SHUT_RD, socket.SHUT_RDWR):
            self._ended = True
        if how in (socket.SHUT_WR, socket.SHUT_RDWR):
            self._mute = True
            self._other._ended = True

    def close(self) -> None:
        """Close it; the other end is reset if bytes were not read."""
        if self._fd < 0:
            return
        number, self._fd = self._fd, -1
        self._network.close(number)
        if self._waiting is not None:
            self._network.listeners.pop(self._port, None)
            for sock in self._waiting:
                sock.break_off()
        other = self._other
        if other is not None:
            other._ended = True
            if self._inbox and other._fd >= 0:
                other._broken = errno.ECONNRESET
        if not self._network.scheduler.over:
            self._network.scheduler.point()

    def break_off(self) -> None:
        """Reset the connection, as if a machine had gone."""
        if self._other is not None and self._other._fd >= 0:
            self._other._broken = errno.ECONNRESET
            self._other._ended = True
        if self._fd >= 0:
            self._broken = errno.ECONNRESET
            self._ended = True

    def __enter__(self) -> Socket:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # Waiting ----------------------------------------------------------------------------------------------------------

    def _check(self) -> None:
        if self._fd < 0:
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
        if short or self._inbox:
            return
        if timeout is not None and timeout > 0:
            raise TimeoutError("timed out")
        raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"the stand-in for sockets has no {name}")


class SocketModule:
    """As the module socket.

    Args:
        now: returns the network of the present run.
    """

    def __init__(self, now: Callable[[], Network]) -> None:
        self._now = now

    def socket(self, _family: int = socket.AF_INET, type: int = socket.SOCK_STREAM) -> Socket:
        """Return a socket."""
        if type != socket.SOCK_STREAM:
            raise fault(errno.EPROTONOSUPPORT)
        return Socket(self._now())

    def socketpair(self) -> tuple[Socket, Socket]:
        """Return two ends of a connection."""
        return self._now().pair()

    def create_server(self, address: tuple[str, int], **_options: object) -> Socket:
        """Return a socket that listens."""
        sock = self.socket()
        sock.bind(address)
        sock.listen()
        return sock

    def create_connection(self, address: tuple[str, int], timeout: float | None = None) -> Socket:
        """Return a connected socket."""
        sock = self.socket()
        sock.settimeout(timeout)
        sock.connect(address)
        return sock

    def __getattr__(self, name: str) -> Any:
        return getattr(socket, name)
