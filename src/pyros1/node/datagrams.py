"""Links over UDP, for those who would rather lose a message than wait for it: UDPROS, as roscpp has it (T57-T62).

A subscriber offers a socket in `requestTopic`; the publisher answers with a connection number and sends. There is no
connection that could be found broken: a publisher learns that nobody listens when the system says so, a subscriber
that the publisher has gone when the master says so.
"""

from __future__ import annotations

import contextlib
import itertools
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.net.loop import READ
from pyros1.node.inbox import Inbox
from pyros1.node.local import UNBOUNDED_LIMIT
from pyros1.wire.datagram import LARGEST_SIZE, SMALLEST_SIZE, Assembler, split
from pyros1.wire.header import decode_header, encode_header

if TYPE_CHECKING:
    from pyros1.net.hosts import LocalAddress
    from pyros1.net.loop import Loop
    from pyros1.node.lane import Lane
    from pyros1.node.sources import Item, Source
    from pyros1.node.subscription import Subscription
    from pyros1.wire.outqueue import Frame

PROTOCOL = "UDPROS"
_AT_ONCE = 256
"""Datagrams that are received before the loop sees to its other work."""
_BUFFER = 4 << 20
"""Bytes that the system is asked to keep for a subscriber; it may allow less."""
_LENGTH = 4


class DatagramLink:
    """The sending end. A message that the system does not take at once is lost, and counted as dropped.

    Args:
        loop: of the node, to look up the subscriber's host.
        lane: of the topic, in which `send` is called, and all that concerns the socket is done.
        header: the subscriber's connection header.
        answer: the publisher's.
        place: its host and port.
        size: bytes of the largest datagram.
        connection: the number of this link.
        on_closed: called once, when the link is gone.
    """

    transport = PROTOCOL

    def __init__(
        self,
        loop: Loop,
        lane: Lane,
        header: dict[str, str],
        answer: dict[str, str],
        place: tuple[str, int],
        size: int,
        connection: int,
        on_closed: Callable[[DatagramLink], None],
    ) -> None:
        self.header = header
        self.peer = header.get("callerid", "")
        self.address = f"UDPROS connection on port 0 to [{place[0]}:{place[1]} on socket 0]"
        self.messages = 0
        self.bytes_sent = 0
        self.dropped = 0
        self.waiting = 0
        self._answer = answer
        self._place = place
        self._size = size
        self._connection = connection
        self._on_closed = on_closed
        self._numbers = itertools.count()
        self._lane = lane
        self._sock: socket.socket | None = None
        self._early: bytes | None = None  # the last message from before the host's address was known
        self._open = True
        loop.resolver.resolve(place[0], self._resolved)

    def answer(self, host: str) -> list[Any]:
        """Return what `requestTopic` answers (T59).

        Args:
            host: of this node.
        """
        sock = self._sock
        port = sock.getsockname()[1] if sock is not None else 0
        return [PROTOCOL, host, port, self._connection, self._size, encode_header(self._answer)[_LENGTH:]]

    def start(self) -> None:
        """There is no greeting: the answer to `requestTopic` is."""

    def recover(self) -> None:
        """Nothing is kept that could be half done."""

    def wait(self) -> None:
        """What the system does not take is lost, not waited for."""

    @property
    def connected(self) -> bool:
        """Whether the link is up."""
        return self._open

    def _resolved(self, addresses: list[str], error: OSError | None) -> None:
        if error is not None or not addresses:
            self.close()
            return
        address = addresses[0]
        sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_DGRAM)
        sock.setblocking(False)
        try:
            sock.connect((address, self._place[1]))
        except OSError:
            sock.close()
            self.close()
            return
        self._lane.do(self._begin, sock, address)

    def _begin(self, sock: socket.socket, address: str) -> None:
        if not self._open:
            sock.close()
            return
        port, number = sock.getsockname()[1], sock.fileno()
        self.address = f"UDPROS connection on port {port} to [{address}:{self._place[1]} on socket {number}]"
        self._sock, early, self._early = sock, self._early, None
        if early is not None and not self._send(early):
            self._end()

    def send(self, frame: Frame) -> None:
        """Send a frame, or lose it. Never waits."""
        if not self._open:
            return
        data = frame if isinstance(frame, bytes) else b"".join(frame)
        self.messages += 1
        if self._sock is None:
            self.dropped += self._early is not None
            self._early = data
        elif not self._send(data):
            self._end()

    def _send(self, data: bytes) -> bool:
        """Send a frame's datagrams; return False if nobody listens any more."""
        sock = self._sock
        if sock is None:
            return False
        try:
            for datagram in split(data, self._connection, next(self._numbers), self._size):
                sock.send(datagram)
        except (BlockingIOError, ValueError):
            self.dropped += 1
        except OSError:  # the other side's system: there is no such port
            return False
        else:
            self.bytes_sent += len(data)
        return True

    def close(self) -> None:
        """End the link. Any thread."""
        self._lane.do(self._end)

    def _end(self) -> None:
        if self._open:
            self._open = False
            sock, self._sock = self._sock, None
            if sock is not None:
                sock.close()
            self._on_closed(self)

    def finish(self, until: float) -> None:
        """End the link; nothing waits on this side."""
        self.close()


class DatagramInLink:
    """The receiving end: a socket that is offered to a publisher, and a link once that has answered. On the loop.

    Args:
        subscription: takes the messages.
        uri: the publisher's slave API.
        address: where to listen.
        size: bytes of the largest datagram.

    Attributes:
        header: the publisher's connection header.
        messages, bytes_received: so far.

    Raises:
        OSError: there is no such socket to be had.
    """

    transport = PROTOCOL

    def __init__(self, subscription: Subscription, uri: str, address: LocalAddress, size: int) -> None:
        self.uri = uri
        self.header: dict[str, str] = {}
        self.messages = 0
        self.bytes_received = 0
        self.address = ""
        self._subscription = subscription
        self._loop = subscription.context.loop
        self._host = address.advertised
        self._size = size
        self._open = False
        self._inbox: Inbox[Source, Item] = Inbox(self)
        self._assembler = Assembler(0)
        self._sock = socket.socket(address.family, socket.SOCK_DGRAM)
        try:
            self._sock.bind((address.bind, 0))
            self._sock.setblocking(False)
            self._sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        except OSError:
            self._sock.close()
            raise

    @property
    def connected(self) -> bool:
        """Whether the link is up."""
        return self._open

    def offer(self) -> list[Any]:
        """Return what `requestTopic` is told of it (T58)."""
        header = encode_header(self._subscription.request_header())[_LENGTH:]
        return [PROTOCOL, header, self._host, self._sock.getsockname()[1], self._size]

    def begin(self, header: dict[str, str], place: tuple[str, int], connection: int) -> None:
        """The publisher has accepted: receive.

        Args:
            header: the publisher's.
            place: its host and port.
            connection: the number that it gave the link.
        """
        self.header = header
        self._assembler = Assembler(connection)
        port, number = self._sock.getsockname()[1], self._sock.fileno()
        self.address = f"UDPROS connection on port {port} to [{place[0]}:{place[1]} on socket {number}]"
        self._open = True
        self._subscription.reader.handover.open(self._inbox)
        self._loop.register(self._sock, READ, self._receive)

    def _receive(self, _mask: int) -> None:
        reader = self._subscription.reader
        for _ in range(_AT_ONCE):
            try:
                datagram = self._sock.recv(LARGEST_SIZE)
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
                reader.push(self._inbox, body, UNBOUNDED_LIMIT)  # the loop must not wait for callbacks
            if not self._open:
                return

    def close(self) -> None:
        """End the link, or take the offer back. Any thread."""
        begun, self._open = self._open, False
        self._loop.call_soon(self._close_socket)
        if begun:
            self._subscription.local_closed(self)

    def _close_socket(self) -> None:
        with contextlib.suppress(ValueError, OSError):
            self._loop.unregister(self._sock)
        self._sock.close()


def read_offer(offer: list[Any]) -> tuple[dict[str, str], tuple[str, int], int] | None:
    """Return header, place and datagram size of a subscriber's offer, or None if it is none.

    Raises:
        ProtocolError: the header is broken.
    """
    match offer:
        case ["UDPROS", bytes(header), str(host), int(port), int(size), *_] if 0 < port < 65536:
            return decode_header(header), (host, port), min(max(size, SMALLEST_SIZE), LARGEST_SIZE)
    return None


def read_answer(answer: list[Any]) -> tuple[dict[str, str], tuple[str, int], int] | None:
    """Return header, place and connection number of a publisher's answer (T59), or None if it is none.

    Raises:
        ProtocolError: the header is broken.
    """
    match answer:
        case ["UDPROS", str(host), int(port), int(connection), int(), bytes(header), *_]:
            return decode_header(header), (host, port), connection & 0xFFFFFFFF
    return None
