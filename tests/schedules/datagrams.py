"""A stand-in for UDP sockets: datagrams within the test, of which some are lost if the plan says so.

As on Linux, a datagram to a port that nobody has makes the next call of a connected sender fail, and what finds no room
at the receiver is lost.
"""

from __future__ import annotations

import errno
from collections import deque

from .network import HOST, Buffer, Network, Socket, fault


class DatagramSocket(Socket):
    """As socket.socket, for UDP.

    Attributes:
        waiting: datagrams that have come.
    """

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        self.waiting: deque[bytes] = deque()
        self._to = 0

    def bind(self, address: tuple[str, int]) -> None:
        """Take a port."""
        super().bind(address)
        self._network.datagrams[self.port] = self

    def connect(self, address: tuple[str, int]) -> None:
        """Send to a port from now on."""
        self._to = address[1]
        if not self.port:
            self.bind((HOST, 0))

    @property
    def readable(self) -> bool:
        """Whether a read does not wait."""
        return bool(self.waiting or self.broken)

    @property
    def writable(self) -> bool:
        """Whether a write does not wait."""
        return True

    def recv(self, size: int, flags: int = 0) -> bytes:
        """Receive a datagram."""
        self._until(lambda: self.readable, self._patience(0, flags))
        return self.waiting.popleft()[:size]

    def send(self, data: Buffer, flags: int = 0) -> int:
        """Send a datagram, or lose it."""
        self._check()
        self._network.scheduler.point()
        if self.broken:
            number, self.broken = self.broken, 0
            raise fault(number)
        other = self._network.datagrams.get(self._to)
        if not isinstance(other, DatagramSocket):
            self.broken = errno.ECONNREFUSED
        elif self._network.part(2) < 2 or sum(map(len, other.waiting)) > self._network.room:
            self._network.lost += 1
        else:
            other.waiting.append(bytes(data))
        return len(data)

    def close(self) -> None:
        """Free the port."""
        if self.fd >= 0:
            self._network.datagrams.pop(self.port, None)
        super().close()
