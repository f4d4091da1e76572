"""Framing of service calls (https://wiki.ros.org/ROS/TCPROS).

::

    request    u32 length, body
    response   u8 ok (1), u32 length, body
    failure    u8 ok (0), u32 length, error text
"""

from __future__ import annotations

import struct

from pyros1.ground.errors import ProtocolError
from pyros1.wire.framing import MAX_MESSAGE_SIZE

_RESPONSE_HEAD = struct.Struct("<BI")
RESPONSE_HEAD_SIZE = _RESPONSE_HEAD.size


def encode_success(frame: bytes) -> bytes:
    """Return a successful response; ``frame`` is the response message preceded by its length."""
    return b"\x01" + frame


def encode_failure(reason: str) -> bytes:
    """Return a failure response with its reason."""
    text = reason.encode("utf-8", "replace")
    return _RESPONSE_HEAD.pack(0, len(text)) + text


def decode_response_head(head: bytes | bytearray, limit: int = MAX_MESSAGE_SIZE) -> tuple[bool, int]:
    """Return (whether the call succeeded, length of the body) from at least the first RESPONSE_HEAD_SIZE bytes of a
    response.

    Raises:
        ProtocolError: the body would be larger than ``limit`` bytes.
    """
    ok, size = _RESPONSE_HEAD.unpack_from(head)
    if size > limit:
        raise ProtocolError(f"service response of {size} bytes exceeds the limit of {limit} bytes")
    return ok != 0, size
