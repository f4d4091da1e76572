"""The stand-in for the module `socket`: it makes the sockets of `network`, `datagrams` and `unix_sockets`."""

from __future__ import annotations

import socket
from collections.abc import Callable
from typing import Any

from . import unix_sockets
from .datagrams import DatagramSocket
from .network import Network, Socket

STREAM = socket.SOCK_STREAM


class SocketModule:
    """As the module socket.

    Args:
        now: returns the network of the present run.
    """

    def __init__(self, now: Callable[[], Network]) -> None:
        self._now = now

    def socket(self, _family: int = socket.AF_INET, type: int = STREAM) -> Socket:
        """Return a socket."""
        if type == socket.SOCK_DGRAM:
            return DatagramSocket(self._now())
        return Socket(self._now())

    def socketpair(self, _family: int = 0, type: int = STREAM) -> tuple[Socket, Socket]:
        """Return two ends of a connection."""
        if type == socket.SOCK_SEQPACKET:
            return unix_sockets.pair(self._now(), unix_sockets.RecordSocket)
        return self._now().pair()

    def send_fds(self, sock: Any, buffers: Any, descriptors: Any) -> int:
        """Send bytes with descriptors."""
        return unix_sockets.send_fds(self._now(), sock, buffers, descriptors)

    def recv_fds(self, sock: Any, size: int, most: int, _flags: int = 0) -> Any:
        """Receive bytes with descriptors."""
        return unix_sockets.recv_fds(sock, size, most)

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
