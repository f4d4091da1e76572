"""A publisher's link over UDP (UDPROS, as in roscpp), which drops messages instead of waiting.

A subscriber offers a socket in `requestTopic`; the publisher responds with a connection number and starts to send.
There is no connection that could break: only system errors tell a publisher that nobody is listening (T57-T62).
"""

from __future__ import annotations

import itertools
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.wire.datagram import split_frame
from pyros1.wire.header import encode_header

if TYPE_CHECKING:
    from pyros1.net.loop import Loop
    from pyros1.node.strand import Strand
    from pyros1.wire.outqueue import Frame

PROTOCOL = "UDPROS"
_LENGTH_SIZE = 4


class UdpLink:
    """The sending end of a link. A message that the system does not accept immediately is counted as dropped.

    Args:
        loop: the node's loop, which looks up the subscriber's host.
        strand: the topic's strand, in which `send` is called and the socket is used.
        header: the subscriber's connection header.
        response_header: the publisher's connection header.
        peer_address: the subscriber's host and port.
        max_size: maximum size of a datagram in bytes.
        connection_number: the connection number of this link.
        on_closed: called once when the link is closed.
    """

    transport = PROTOCOL

    def __init__(
        self,
        loop: Loop,
        strand: Strand,
        header: dict[str, str],
        response_header: dict[str, str],
        peer_address: tuple[str, int],
        max_size: int,
        connection_number: int,
        on_closed: Callable[[UdpLink], None],
    ) -> None:
        self.header = header
        self.peer = header.get("callerid", "")
        self.address = f"UDPROS connection on port 0 to [{peer_address[0]}:{peer_address[1]} on socket 0]"
        self.messages = 0
        self.bytes_sent = 0
        self.dropped = 0
        self.waiting = 0
        self._response_header = response_header
        self._peer_address = peer_address
        self._max_size = max_size
        self._connection_number = connection_number
        self._on_closed = on_closed
        self._message_numbers = itertools.count()
        self._strand = strand
        self._sock: socket.socket | None = None
        self._early_frame: bytes | None = None  # the last message before the host's address was known
        self._is_open = True
        loop.resolver.resolve(peer_address[0], self._on_resolved)

    def topic_response(self, host: str) -> list[Any]:
        """Return the response to `requestTopic` (T59).

        Args:
            host: the host that this node advertises.
        """
        sock = self._sock
        port = sock.getsockname()[1] if sock is not None else 0
        return [
            PROTOCOL,
            host,
            port,
            self._connection_number,
            self._max_size,
            encode_header(self._response_header)[_LENGTH_SIZE:],
        ]

    def start(self) -> None:
        """Do nothing: the connection header is part of the response to `requestTopic`."""

    def recover(self) -> None:
        """Do nothing: messages are not queued here."""

    def wait(self) -> None:
        """Do nothing: messages that the system does not accept are lost."""

    @property
    def connected(self) -> bool:
        """Whether the link is open."""
        return self._is_open

    def _on_resolved(self, addresses: list[str], error: OSError | None) -> None:
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
        self._strand.do(self._set_socket, sock, address)

    def _set_socket(self, sock: socket.socket, address: str) -> None:
        if not self._is_open:
            sock.close()
            return
        port, fd = sock.getsockname()[1], sock.fileno()
        self.address = f"UDPROS connection on port {port} to [{address}:{self._peer_address[1]} on socket {fd}]"
        self._sock, early_frame, self._early_frame = sock, self._early_frame, None
        if early_frame is not None and not self._send_datagrams(early_frame):
            self._close_now()

    def send(self, frame: Frame) -> None:
        """Send a frame, or drop it. Never blocks."""
        if not self._is_open:
            return
        data = frame if isinstance(frame, bytes) else b"".join(frame)
        self.messages += 1
        if self._sock is None:
            self.dropped += self._early_frame is not None
            self._early_frame = data
        elif not self._send_datagrams(data):
            self._close_now()

    def _send_datagrams(self, data: bytes) -> bool:
        """Send the datagrams of a frame; return False if nobody is listening anymore."""
        sock = self._sock
        if sock is None:
            return False
        try:
            for datagram in split_frame(data, self._connection_number, next(self._message_numbers), self._max_size):
                sock.send(datagram)
        except (BlockingIOError, ValueError):
            self.dropped += 1
        except OSError:  # the other machine reports that no socket uses that port
            return False
        else:
            self.bytes_sent += len(data)
        return True

    def close(self) -> None:
        """Close the link. Thread-safe."""
        self._strand.do(self._close_now)

    def _close_now(self) -> None:
        if self._is_open:
            self._is_open = False
            sock, self._sock = self._sock, None
            if sock is not None:
                sock.close()
            self._on_closed(self)

    def finish(self, deadline: float) -> None:
        """Close the link; no messages are queued on this side."""
        self.close()
