"""The receiving end of a link over UDP: a socket that is offered to a publisher, which then sends to it (T57-T62).

No datagram signals that the publisher is gone: only the master does.
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.net.hosts import is_own_address
from pyros1.net.loop import READ
from pyros1.net.ports import datagram_socket
from pyros1.node.subscribing.queues import UNBOUNDED_LIMIT, Inbox
from pyros1.wire.datagram import MAX_DATAGRAM_SIZE, Assembler
from pyros1.wire.header import encode_header

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist
    from pyros1.net.hosts import LocalAddress
    from pyros1.net.loop import Loop
    from pyros1.node.subscribing.delivery_loop import DeliveryLoop

_MAX_PER_TURN = 256
"""Maximum number of datagrams received before the loop does other work."""
_BUFFER = 4 << 20
"""Requested size of the receive buffer in bytes; the system may allow less."""
_MAX_SENDERS = 1000
_LENGTH = 4


class UdpSource:
    """The receiving end: a socket that is offered to a publisher, and a link once it has answered. On the loop.

    Args:
        loop: the node's loop.
        delivery: delivers the messages.
        header: the subscriber's connection header.
        uri: the publisher's slave API.
        address: address to listen on.
        allowlist: decides which hosts' datagrams are accepted; None accepts all.
        size: bytes of the largest datagram.
        on_closed: called once, when the link is gone.

    Attributes:
        header: the publisher's connection header.
        messages, bytes_received: numbers so far.

    Raises:
        OSError: the socket cannot be opened.
    """

    transport = "UDPROS"

    def __init__(
        self,
        loop: Loop,
        delivery: DeliveryLoop,
        header: dict[str, str],
        uri: str,
        address: LocalAddress,
        allowlist: Allowlist | None,
        size: int,
        on_closed: Callable[[UdpSource], None],
    ) -> None:
        self.uri = uri
        self.header: dict[str, str] = {}
        self.messages = 0
        self.bytes_received = 0
        self.address = ""
        self._delivery = delivery
        self._loop = loop
        self._header = header
        self._on_closed = on_closed
        self._host = address.advertised
        self._size = size
        self._open = False
        self._inbox = Inbox(self)
        self._assembler = Assembler(0)
        self._allowlist = allowlist
        self._known: dict[str, bool] = {}  # senders, and whether their datagrams are accepted
        self._sock = datagram_socket(address.bind, address.ports)
        self._take = self._sock.recv if allowlist is None else self._receive_allowed
        with contextlib.suppress(OSError):
            self._sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)

    @property
    def connected(self) -> bool:
        """Whether the link is up."""
        return self._open

    def offer(self) -> list[Any]:
        """Return the offer for the call of `requestTopic` (T58)."""
        header = encode_header(self._header)[_LENGTH:]
        return ["UDPROS", header, self._host, self._sock.getsockname()[1], self._size]

    def begin(self, header: dict[str, str], peer_address: tuple[str, int], connection: int) -> None:
        """Start receiving, since the publisher has accepted.

        Args:
            header: the publisher's connection header.
            peer_address: the publisher's host and port.
            connection: the number that the publisher gave the link.
        """
        self.header = header
        self._assembler = Assembler(connection)
        port, number = self._sock.getsockname()[1], self._sock.fileno()
        self.address = f"UDPROS connection on port {port} to [{peer_address[0]}:{peer_address[1]} on socket {number}]"
        self._open = True
        self._delivery.inboxes.open(self._inbox)
        self._loop.register(self._sock, READ, self._receive)

    def _receive(self, _mask: int) -> None:
        for _ in range(_MAX_PER_TURN):
            try:
                datagram = self._take(MAX_DATAGRAM_SIZE)
            except BlockingIOError:
                return
            except OSError:
                self.close()
                return
            body = self._assembler.feed(datagram)
            self._inbox.lost = self._assembler.lost
            if body is not None:
                self.messages += 1
                self.bytes_received += len(body) + _LENGTH
                self._delivery.push(self._inbox, body, UNBOUNDED_LIMIT)  # the loop must not wait for callbacks
            if not self._open:
                return

    def _receive_allowed(self, size: int) -> bytes:
        """Return a datagram; an empty one in place of a rejected one."""
        datagram, (sender, *_) = self._sock.recvfrom(size)
        accepted = self._known.get(sender)
        if accepted is None:
            if len(self._known) >= _MAX_SENDERS:
                self._known.clear()
            local_address = sender if is_own_address(sender) else ""
            accepted = self._known[sender] = self._allowlist is None or self._allowlist.allows(sender, local_address)
        return datagram if accepted else b""

    def close(self) -> None:
        """End the link, or withdraw the offer. Thread-safe."""
        was_begun, self._open = self._open, False
        self._loop.call_soon(self._close_socket)
        if was_begun:
            self._on_closed(self)

    def _close_socket(self) -> None:
        with contextlib.suppress(ValueError, OSError):
            self._loop.unregister(self._sock)
        self._sock.close()
