"""Connection headers (https://wiki.ros.org/ROS/Connection%20Header).

On the wire a header is::

    u32  total length of what follows (little-endian)
    repeated:
        u32  field length
        ...  "key=value"; the value may contain '=' and any bytes

Here, values are strings. Bytes that are not UTF-8 (comments in message definitions are often Latin-1) are kept as
surrogate escapes, so that a header can be forwarded unchanged.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

from pyros1.ground.errors import ProtocolError

MAX_HEADER_SIZE = 1 << 24
"""Maximum size in bytes of a header from a peer. The largest field is the message definition, usually tens of
kilobytes, but stock has no limit. Memory is only used as bytes arrive.
"""

_U32 = struct.Struct("<I")


def encode_header(fields: Mapping[str, str]) -> bytes:
    """Return the header's bytes, preceded by their length; keys are sorted, as in rospy."""
    parts = []
    for key in sorted(fields):
        encoded_field = f"{key}={fields[key]}".encode("utf-8", "surrogateescape")
        parts.append(_U32.pack(len(encoded_field)))
        parts.append(encoded_field)
    body = b"".join(parts)
    return _U32.pack(len(body)) + body


def decode_header(body: bytes) -> dict[str, str]:
    """Return the fields of a header, given its bytes without the total length.

    Raises:
        ProtocolError: a field is empty, has no ``=`` or runs past the end.
    """
    fields: dict[str, str] = {}
    position, end = 0, len(body)
    while position < end:
        if end - position < 4:
            raise ProtocolError(f"connection header: {end - position} stray bytes at offset {position}")
        (size,) = _U32.unpack_from(body, position)
        position += 4
        if size > end - position:
            raise ProtocolError(f"connection header: field of {size} bytes at offset {position} runs past the end")
        field = body[position : position + size]
        key, separator, value = field.partition(b"=")
        if not separator:
            raise ProtocolError(f"connection header: field at offset {position} has no '='")
        fields[key.strip().decode("utf-8", "surrogateescape")] = value.decode("utf-8", "surrogateescape")
        position += size
    return fields


class HeaderReader:
    """Reads one header from bytes that arrive in arbitrary pieces.

    Args:
        limit: maximum total length of an accepted header in bytes.

    Attributes:
        bytes_after_header: when the header is complete, the bytes that arrived after it.
    """

    def __init__(self, limit: int = MAX_HEADER_SIZE) -> None:
        self._limit = limit
        self._data = bytearray()
        self.bytes_after_header = b""

    def feed(self, data: bytes) -> dict[str, str] | None:
        """Process more bytes; return the fields if the header is complete now, or None.

        Raises:
            ProtocolError: the header is too long or malformed.
        """
        self._data += data
        if len(self._data) < 4:
            return None
        (size,) = _U32.unpack_from(self._data)
        if size > self._limit:
            raise ProtocolError(f"connection header of {size} bytes exceeds the limit of {self._limit} bytes")
        if len(self._data) < 4 + size:
            return None
        self.bytes_after_header = bytes(self._data[4 + size :])
        return decode_header(bytes(self._data[4 : 4 + size]))
