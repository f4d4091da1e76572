"""The receiving end of a link over UDP: a socket that is offered to a publisher, which then sends to it (T57-T62).

No datagram tells that the publisher is gone; only the master reports it.
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

_MAX_DATAGRAMS_PER_TURN = 256
"""Maximum number of datagrams received before the loop does other work."""
_BUFFER_SIZE = 4 << 20
"""Requested size of the receive buffer in bytes; the system may allow less."""
MAX_SENDERS = 1000
"""Maximum number of senders for which the result of the allowlist is remembered."""
_LENGTH_SIZE = 4


class UdpSource:
    """The receiving end of a link: a socket that is offered to a publisher, and the link once the publisher has
    accepted. Used on the loop.

    Args:
        loop: the node's loop.
        delivery: delivers the messages.
        header: the subscriber's connection header.
        uri: URI of the publisher's slave API.
        address: the address to listen on, and the host to advertise.
        allowlist: decides which hosts' datagrams are accepted; None accepts all.
        max_size: maximum size of a datagram in bytes.
        on_closed: called with this source, once, when the link is closed.

    Attributes:
        header: the publisher's connection header.
        messages, bytes_received: number of messages and bytes received so far.

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
        max_size: int,
        on_closed: Callable[[UdpSource], None],
    ) -> None:
        self.uri = uri
        self.header: dict[str, str] = {}
        self.messages = 0
        self.bytes_received = 0
        self.address = ""
        self._delivery = delivery
        self._loop = loop
        self._request_header = header
        self._on_closed = on_closed
        self._host = address.advertised
        self._max_size = max_size
        self._is_open = False
        self._inbox = Inbox(self)
        self._assembler = Assembler(0)
        self._allowlist = allowlist
        self._is_accepted_by_sender: dict[str, bool] = {}  # sender's address -> allowed
        self._sock = datagram_socket(address.bind, address.ports)
        self._receive_datagram = self._sock.recv if allowlist is None else self._receive_allowed
        with contextlib.suppress(OSError):
            self._sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_SIZE)

    @property
    def connected(self) -> bool:
        """Whether the link is open."""
        return self._is_open

    def offer(self) -> list[Any]:
        """Return the offer to pass to `requestTopic` (T58)."""
        header = encode_header(self._request_header)[_LENGTH_SIZE:]
        return ["UDPROS", header, self._host, self._sock.getsockname()[1], self._max_size]

    def begin(self, header: dict[str, str], peer_address: tuple[str, int], connection_number: int) -> None:
        """Start receiving, since the publisher has accepted.

        Args:
            header: the publisher's connection header.
            peer_address: the publisher's host and port.
            connection_number: the connection number assigned by the publisher.
        """
        self.header = header
        self._assembler = Assembler(connection_number)
        port, fd = self._sock.getsockname()[1], self._sock.fileno()
        self.address = f"UDPROS connection on port {port} to [{peer_address[0]}:{peer_address[1]} on socket {fd}]"
        self._is_open = True
        self._delivery.inboxes.add(self._inbox)
        self._loop.register(self._sock, READ, self._receive)

    def _receive(self, _mask: int) -> None:
        for _ in range(_MAX_DATAGRAMS_PER_TURN):
            try:
                datagram = self._receive_datagram(MAX_DATAGRAM_SIZE)
            except BlockingIOError:
                return
            except OSError:
                self.close()
                return
            body = self._assembler.feed(datagram)
            self._inbox.lost = self._assembler.lost
            if body is not None:
                self.messages += 1
                self.bytes_received += len(body) + _LENGTH_SIZE
                self._delivery.push(self._inbox, body, UNBOUNDED_LIMIT)  # the loop must not wait for callbacks
            if not self._is_open:
                return

    def _receive_allowed(self, size: int) -> bytes:
        """Receive a datagram and return it; return an empty one if its sender is not allowed."""
        datagram, (sender, *_) = self._sock.recvfrom(size)
        is_accepted = self._is_accepted_by_sender.get(sender)
        if is_accepted is None:
            if len(self._is_accepted_by_sender) >= MAX_SENDERS:
                self._is_accepted_by_sender.clear()
            local_address = sender if is_own_address(sender) else ""
            is_accepted = self._is_accepted_by_sender[sender] = (
                self._allowlist is None or self._allowlist.admit_address(sender, local_address)
            )
        return datagram if is_accepted else b""

    def close(self) -> None:
        """Close the link, or withdraw the offer. Thread-safe."""
        was_open, self._is_open = self._is_open, False
        self._loop.call_soon(self._close_socket)
        if was_open:
            self._on_closed(self)

    def _close_socket(self) -> None:
        with contextlib.suppress(ValueError, OSError):
            self._loop.unregister(self._sock)
        self._sock.close()
