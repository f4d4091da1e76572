"""UDPROS: splits frames into datagrams, and assembles them again (https://wiki.ros.org/ROS/UDPROS; T57-T62).

A datagram contains the connection's number, an operation, the message's number (which wraps around), a block number and
part of the frame (a block). The first datagram of a frame has the operation DATA0, and the number of blocks in place of
a block number; the others have the operation DATAN and their index. Nothing is resent: if a block is lost or out of
order, its message is lost.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

from pyros1.wire.header import decode_header

DATA0, DATAN = 0, 1
MIN_DATAGRAM_SIZE, MAX_DATAGRAM_SIZE = 64, 65507
MAX_BLOCKS = 0xFFFF
MAX_ASSEMBLED_SIZE = 1 << 30
"""Maximum size in bytes of a message that is accepted from a peer."""
_HEAD = struct.Struct("<IBBH")
_LENGTH_FIELD = struct.Struct("<I")


def split_frame(frame: bytes, connection_number: int, message_number: int, max_size: int) -> Iterator[bytes]:
    """Yield the datagrams of a frame.

    Args:
        frame: the body preceded by its length, as in TCPROS.
        connection_number: the number that the publisher assigned to the connection.
        message_number: the number of the message; the lowest 8 bits are used.
        max_size: maximum size of a datagram in bytes.

    Raises:
        ValueError: the frame would need more than `MAX_BLOCKS` blocks.
    """
    payload_size = max_size - _HEAD.size
    block_count = -(-len(frame) // payload_size)
    if block_count > MAX_BLOCKS:
        raise ValueError(f"{len(frame)} bytes are too large for datagrams of {max_size} bytes")
    for index in range(block_count):
        operation, block = (DATAN, index) if index else (DATA0, block_count)
        yield (
            _HEAD.pack(connection_number, operation, message_number & 0xFF, block)
            + frame[index * payload_size : (index + 1) * payload_size]
        )


class Assembler:
    """Assembles message bodies from the datagrams of one connection.

    Args:
        connection_number: the connection's number; datagrams of other connections are ignored.

    Attributes:
        lost: number of messages that were started but not completed.
    """

    def __init__(self, connection_number: int) -> None:
        self.lost = 0
        self._connection_number = connection_number
        self._message_number = 0
        self._block_count = 0  # number of blocks of the message being assembled; 0 for none
        self._parts: list[bytes] = []

    def feed(self, datagram: bytes) -> bytes | None:
        """Process a datagram; return the body of the message that it completes, or None."""
        if len(datagram) < _HEAD.size:
            return None
        connection_number, operation, message_number, block = _HEAD.unpack_from(datagram)
        if connection_number != self._connection_number or operation not in (DATA0, DATAN):
            return None
        if operation == DATA0:
            self._discard_parts()
            self._message_number = message_number
            self._block_count = block if block * len(datagram) <= MAX_ASSEMBLED_SIZE else 0
        elif message_number != self._message_number or block != len(self._parts):
            self._discard_parts()
        if self._block_count:
            self._parts.append(datagram[_HEAD.size :])
        return self._take_body() if self._block_count and len(self._parts) == self._block_count else None

    def _take_body(self) -> bytes | None:
        frame = b"".join(self._parts)
        self._parts, self._block_count = [], 0
        if len(frame) >= _LENGTH_FIELD.size and _LENGTH_FIELD.unpack_from(frame)[0] == len(frame) - _LENGTH_FIELD.size:
            return frame[_LENGTH_FIELD.size :]
        self.lost += 1
        return None

    def _discard_parts(self) -> None:
        self.lost += bool(self._parts)
        self._parts, self._block_count = [], 0


def parse_udpros_offer(offer: list[Any]) -> tuple[dict[str, str], tuple[str, int], int] | None:
    """Return the header, the (host, port) and the datagram size from a subscriber's offer, or None if it is not a
    UDPROS offer.

    Raises:
        ProtocolError: the header is malformed.
    """
    match offer:
        case ["UDPROS", bytes(header), str(host), int(port), int(size), *_] if 0 < port < 65536:
            return decode_header(header), (host, port), min(max(size, MIN_DATAGRAM_SIZE), MAX_DATAGRAM_SIZE)
    return None


def parse_udpros_response(response: list[Any]) -> tuple[dict[str, str], tuple[str, int], int] | None:
    """Return the header, the (host, port) and the connection number from a publisher's response (T59), or None if it is
    not a UDPROS response.

    Raises:
        ProtocolError: the header is malformed.
    """
    match response:
        case ["UDPROS", str(host), int(port), int(connection), int(), bytes(header), *_]:
            return decode_header(header), (host, port), connection & 0xFFFFFFFF
    return None
