"""UDPROS: frames in datagrams (https://wiki.ros.org/ROS/UDPROS; T57-T62). Pure.

A datagram holds the connection's number, an operation, the message's number (which wraps around), a block number and a
part of the frame. The first datagram of a frame has the operation DATA0 and the number of blocks; the others are DATAN
with their index. Nothing is sent again: if a block is lost or out of order, its message is lost.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

from pyros1.wire.header import decode_header

DATA0, DATAN = 0, 1
SMALLEST_SIZE, LARGEST_SIZE = 64, 65507
MAX_BLOCKS = 0xFFFF
MAX_BYTES = 1 << 30
"""Maximum number of blocks of a message that is accepted from a peer."""
_HEAD = struct.Struct("<IBBH")
_SIZE = struct.Struct("<I")


def split(frame: bytes, connection: int, message: int, size: int) -> Iterator[bytes]:
    """Yield the datagrams of a frame.

    Args:
        frame: the body with its length in front, as in TCPROS.
        connection: the number that the publisher gave the connection.
        message: counts the messages; the lowest 8 bits are used.
        size: bytes of the largest datagram.

    Raises:
        ValueError: the frame would need more than MAX_BLOCKS blocks.
    """
    payload_size = size - _HEAD.size
    blocks = -(-len(frame) // payload_size)
    if blocks > MAX_BLOCKS:
        raise ValueError(f"{len(frame)} bytes are too large for datagrams of {size} bytes")
    for index in range(blocks):
        kind, block = (DATAN, index) if index else (DATA0, blocks)
        yield (
            _HEAD.pack(connection, kind, message & 0xFF, block)
            + frame[index * payload_size : (index + 1) * payload_size]
        )


class Assembler:
    """Assembler of message bodies from the datagrams of one connection.

    Args:
        connection: the connection's number; datagrams with another one are ignored.

    Attributes:
        lost: messages that were started but not completed.
    """

    def __init__(self, connection: int) -> None:
        self.lost = 0
        self._connection = connection
        self._message = 0
        self._blocks = 0  # of the message that is being assembled; 0: none
        self._parts: list[bytes] = []

    def feed(self, datagram: bytes) -> bytes | None:
        """Take a datagram; return the body of a message that it completes, else None."""
        if len(datagram) < _HEAD.size:
            return None
        connection, kind, message, block = _HEAD.unpack_from(datagram)
        if connection != self._connection or kind not in (DATA0, DATAN):
            return None
        if kind == DATA0:
            self._drop()
            self._message = message
            self._blocks = block if block * len(datagram) <= MAX_BYTES else 0
        elif message != self._message or block != len(self._parts):
            self._drop()
        if self._blocks:
            self._parts.append(datagram[_HEAD.size :])
        return self._body() if self._blocks and len(self._parts) == self._blocks else None

    def _body(self) -> bytes | None:
        frame = b"".join(self._parts)
        self._parts, self._blocks = [], 0
        if len(frame) >= _SIZE.size and _SIZE.unpack_from(frame)[0] == len(frame) - _SIZE.size:
            return frame[_SIZE.size :]
        self.lost += 1
        return None

    def _drop(self) -> None:
        self.lost += bool(self._parts)
        self._parts, self._blocks = [], 0


def read_offer(offer: list[Any]) -> tuple[dict[str, str], tuple[str, int], int] | None:
    """Return header, (host, port) and datagram size of a subscriber's offer; None if it is something else.

    Raises:
        ProtocolError: the header is broken.
    """
    match offer:
        case ["UDPROS", bytes(header), str(host), int(port), int(size), *_] if 0 < port < 65536:
            return decode_header(header), (host, port), min(max(size, SMALLEST_SIZE), LARGEST_SIZE)
    return None


def read_answer(answer: list[Any]) -> tuple[dict[str, str], tuple[str, int], int] | None:
    """Return header, (host, port) and connection number of a publisher's answer (T59); None if it is something else.

    Raises:
        ProtocolError: the header is broken.
    """
    match answer:
        case ["UDPROS", str(host), int(port), int(connection), int(), bytes(header), *_]:
            return decode_header(header), (host, port), connection & 0xFFFFFFFF
    return None
