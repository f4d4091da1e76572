"""The attachment of each rmw_zenoh message, request and response; rmw_zenoh drops those without one. No I/O.

zenoh's serialization writes integers in little endian, and strings and byte lists after their length.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from pyros1.ground.errors import SerializationError

GID_SIZE = 16
"""Size in bytes of a GID, the identifier of a publisher, client etc."""
_FORM = struct.Struct("<qqB16s")
# rmw_zenoh of ROS 2 Humble before version 0.1.2.
_KEYED_FORM = struct.Struct("<16sq17sq12s16s")
_KEYS = (b"\x0fsequence_number", b"\x10source_timestamp", b"\x0asource_gid\x10")
_LIMIT = 1 << 63


class Attachment(NamedTuple):
    """The attachment of a message, request or response.

    Attributes:
        sequence_number: the number, from 1, of a message from its publisher, or of a request from its client; in a
            response, the number of its request.
        source_time: time at which it was sent, in nanoseconds since 1970.
        gid: 16 bytes that identify the publisher of a message, or the client of a request or response.
    """

    sequence_number: int
    source_time: int
    gid: bytes


def encode_attachment(attachment: Attachment) -> bytes:
    """Return an attachment as 33 bytes.

    Raises:
        SerializationError: a number is out of range, or the GID does not have 16 bytes.
    """
    number, time, gid = attachment
    if not (-_LIMIT <= number < _LIMIT and -_LIMIT <= time < _LIMIT and len(gid) == GID_SIZE):
        raise SerializationError("an attachment has two numbers of 64 bits and 16 bytes")
    return _FORM.pack(number, time, GID_SIZE, gid)


def decode_attachment(data: bytes) -> Attachment | None:
    """Return an attachment written by any version of rmw_zenoh, including before 0.1.2; None if it is not one."""
    if len(data) == _FORM.size:
        number, time, size, gid = _FORM.unpack(data)
        return Attachment(number, time, gid) if size == GID_SIZE else None
    if len(data) == _KEYED_FORM.size:
        key, number, time_key, time, gid_key, gid = _KEYED_FORM.unpack(data)
        return Attachment(number, time, gid) if (key, time_key, gid_key) == _KEYS else None
    return None
