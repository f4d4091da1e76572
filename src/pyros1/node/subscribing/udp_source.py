"""The receiving end of a link over UDP: a socket that is offered to a publisher, which then sends to it (T57-T62).

No datagram tells that the publisher has gone: only the master does.
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.net.hosts import is_own_address
from pyros1.net.loop import READ
from pyros1.net.ports import datagram_socket
from pyros1.node.subscribing.inbox import Inbox
from pyros1.node.subscribing.sources import UNBOUNDED_LIMIT
from pyros1.wire.datagram import LARGEST_SIZE, Assembler
from pyros1.wire.header import encode_header

if TYPE_CHECKING:
    from pyros1.net.guests import Guests
    from pyros1.net.hosts import LocalAddress
    from pyros1.net.loop import Loop
    from pyros1.node.subscribing.sources import Item, Receiver, Source

_AT_ONCE = 256
"""Most datagrams that are received before the loop does other work."""
_BUFFER = 4 << 20
"""Wanted size of the receive buffer in bytes; the system may allow less."""
_MOST_SENDERS = 1000
_LENGTH = 4


class UdpSource:
    """The receiving end: a socket that is offered to a publisher, and a link once that has answered. On the loop.

    Args:
        loop: the node's loop.
        receiver: takes the messages.
        header: the subscriber's connection header.
        uri: the publisher's slave API.
        address: address to listen on.
        guests: decides whose datagrams are taken; None takes all.
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
        receiver: Receiver,
        header: dict[str, str],
        uri: str,
        address: LocalAddress,
        guests: Guests | None,
        size: int,
        on_closed: Callable[[UdpSource], None],
    ) -> None:
        self.uri = uri
        self.header: dict[str, str] = {}
        self.messages = 0
        self.bytes_received = 0
        self.address = ""
        self._receiver = receiver
        self._loop = loop
        self._header = header
        self._on_closed = on_closed
        self._host = address.advertised
        self._size = size
        self._open = False
        self._inbox: Inbox[Source, Item] = Inbox(self)
        self._assembler = Assembler(0)
        self._guests = guests
        self._known: dict[str, bool] = {}  # senders, and whether their datagrams are taken
        self._sock = datagram_socket(address.bind, address.ports)
        self._take = self._sock.recv if guests is None else self._take_from_guests
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

    def begin(self, header: dict[str, str], place: tuple[str, int], connection: int) -> None:
        """Begin to receive, since the publisher has accepted.

        Args:
            header: the publisher's connection header.
            place: the publisher's host and port.
            connection: the number that the publisher gave the link.
        """
        self.header = header
        self._assembler = Assembler(connection)
        port, number = self._sock.getsockname()[1], self._sock.fileno()
        self.address = f"UDPROS connection on port {port} to [{place[0]}:{place[1]} on socket {number}]"
        self._open = True
        self._receiver.open(self._inbox)
        self._loop.register(self._sock, READ, self._receive)

    def _receive(self, _mask: int) -> None:
        for _ in range(_AT_ONCE):
            try:
                datagram = self._take(LARGEST_SIZE)
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
                self._receiver.push(self._inbox, body, UNBOUNDED_LIMIT)  # the loop must not wait for callbacks
            if not self._open:
                return

    def _take_from_guests(self, size: int) -> bytes:
        """Return a datagram, an empty one in the place of one that is not taken."""
        datagram, (sender, *_) = self._sock.recvfrom(size)
        taken = self._known.get(sender)
        if taken is None:
            if len(self._known) >= _MOST_SENDERS:
                self._known.clear()
            here = sender if is_own_address(sender) else ""
            taken = self._known[sender] = self._guests is None or self._guests.may_come(sender, here)
        return datagram if taken else b""

    def close(self) -> None:
        """End the link, or withdraw the offer. Any thread."""
        begun, self._open = self._open, False
        self._loop.call_soon(self._close_socket)
        if begun:
            self._on_closed(self)

    def _close_socket(self) -> None:
        with contextlib.suppress(ValueError, OSError):
            self._loop.unregister(self._sock)
        self._sock.close()
