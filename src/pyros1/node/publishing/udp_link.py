"""A publisher's link over UDP, which loses messages instead of waiting: UDPROS, as in roscpp.

A subscriber offers a socket in `requestTopic`; the publisher answers with a connection number and sends. There is no
connection that could break: only system errors tell a publisher that nobody is listening (T57-T62).
"""

from __future__ import annotations

import itertools
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.wire.datagram import split
from pyros1.wire.header import encode_header

if TYPE_CHECKING:
    from pyros1.net.loop import Loop
    from pyros1.node.strand import Strand
    from pyros1.wire.outqueue import Frame

PROTOCOL = "UDPROS"
_LENGTH = 4


class UdpLink:
    """The sending end. A message that the system does not accept at once is lost and counted as dropped.

    Args:
        loop: the node's loop, which looks up the subscriber's host.
        strand: the topic's strand, in which `send` is called and the socket is used.
        header: the subscriber's connection header.
        answer: the publisher's connection header.
        peer_address: the subscriber's host and port.
        size: bytes of the largest datagram.
        connection: the connection number of this link.
        on_closed: called once, when the link has ended.
    """

    transport = PROTOCOL

    def __init__(
        self,
        loop: Loop,
        strand: Strand,
        header: dict[str, str],
        answer: dict[str, str],
        peer_address: tuple[str, int],
        size: int,
        connection: int,
        on_closed: Callable[[UdpLink], None],
    ) -> None:
        self.header = header
        self.peer = header.get("callerid", "")
        self.address = f"UDPROS connection on port 0 to [{peer_address[0]}:{peer_address[1]} on socket 0]"
        self.messages = 0
        self.bytes_sent = 0
        self.dropped = 0
        self.waiting = 0
        self._answer = answer
        self._peer_address = peer_address
        self._size = size
        self._connection = connection
        self._on_closed = on_closed
        self._numbers = itertools.count()
        self._strand = strand
        self._sock: socket.socket | None = None
        self._early_frame: bytes | None = None  # the last message before the host's address was known
        self._open = True
        loop.resolver.resolve(peer_address[0], self._resolved)

    def answer(self, host: str) -> list[Any]:
        """Return the answer to `requestTopic` (T59).

        Args:
            host: host name of this node.
        """
        sock = self._sock
        port = sock.getsockname()[1] if sock is not None else 0
        return [PROTOCOL, host, port, self._connection, self._size, encode_header(self._answer)[_LENGTH:]]

    def start(self) -> None:
        """Do nothing: the answer to `requestTopic` takes the place of the greeting."""

    def recover(self) -> None:
        """Do nothing: no message is queued here."""

    def wait(self) -> None:
        """Do nothing: messages that the system does not accept are lost."""

    @property
    def connected(self) -> bool:
        """Whether the link is open."""
        return self._open

    def _resolved(self, addresses: list[str], error: OSError | None) -> None:
        if error is not None or not addresses:
            self.close()
            return
        address = addresses[0]
        sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_DGRAM)
        sock.setblocking(False)
        try:
            sock.connect((address, self._peer_address[1]))
        except OSError:
            sock.close()
            self.close()
            return
        self._strand.do(self._begin, sock, address)

    def _begin(self, sock: socket.socket, address: str) -> None:
        if not self._open:
            sock.close()
            return
        port, number = sock.getsockname()[1], sock.fileno()
        self.address = f"UDPROS connection on port {port} to [{address}:{self._peer_address[1]} on socket {number}]"
        self._sock, early_frame, self._early_frame = sock, self._early_frame, None
        if early_frame is not None and not self._send(early_frame):
            self._end()

    def send(self, frame: Frame) -> None:
        """Send a frame, or lose it. Never waits."""
        if not self._open:
            return
        data = frame if isinstance(frame, bytes) else b"".join(frame)
        self.messages += 1
        if self._sock is None:
            self.dropped += self._early_frame is not None
            self._early_frame = data
        elif not self._send(data):
            self._end()

    def _send(self, data: bytes) -> bool:
        """Send a frame's datagrams; return False if nobody is listening any more."""
        sock = self._sock
        if sock is None:
            return False
        try:
            for datagram in split(data, self._connection, next(self._numbers), self._size):
                sock.send(datagram)
        except (BlockingIOError, ValueError):
            self.dropped += 1
        except OSError:  # an error from the other machine: no socket has that port
            return False
        else:
            self.bytes_sent += len(data)
        return True

    def close(self) -> None:
        """End the link. Any thread."""
        self._strand.do(self._end)

    def _end(self) -> None:
        if self._open:
            self._open = False
            sock, self._sock = self._sock, None
            if sock is not None:
                sock.close()
            self._on_closed(self)

    def finish(self, deadline: float) -> None:
        """End the link; no messages wait on this side."""
        self.close()
