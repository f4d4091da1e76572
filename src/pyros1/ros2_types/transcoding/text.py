"""Functions that the generated transcoders call for strings.

A CDR string ends with a zero byte, which its size includes. Each character of a ``wstring`` is a UTF-16 unit in 4
bytes, as written by rosidl_typesupport_fastrtps (seen with rclpy's serialize_message, Kilted).
"""

from __future__ import annotations

import struct

from pyros1.ground.errors import MessageError

ERRORS = (struct.error, MessageError, OverflowError, IndexError, ValueError)
"""The errors that the generated functions raise for invalid messages."""

_read_size = struct.Struct("<I").unpack_from
_SIZE_WRITERS = tuple(struct.Struct(f"<{-residue % 4}xI").pack for residue in range(4))
_write_size = _SIZE_WRITERS[0]


def to_wide(text: bytes | memoryview, _size: int) -> bytes:
    """Return the characters of a ``wstring``.

    Args:
        text: UTF-8; invalid bytes are replaced by U+FFFD.
        _size: its size as sent.
    """
    units = str(text, "utf-8", "replace").encode("utf-16-le")
    wide = bytearray(2 * len(units))
    wide[::4], wide[1::4] = units[::2], units[1::2]
    return bytes(wide)


def from_wide(text: bytes | memoryview, size: int) -> bytes:
    """Return the characters of a ``wstring`` as UTF-8; invalid UTF-16 is replaced by U+FFFD.

    Args:
        text: the characters.
        size: their number as sent.

    Raises:
        MessageError: there are fewer characters, or one does not fit in 16 bits.
    """
    if len(text) != 4 * size:
        raise MessageError("it ends in a wstring")
    text = bytes(text)
    if any(text[2::4]) or any(text[3::4]):
        raise MessageError("it has a wstring that is not UTF-16")
    units = bytearray(2 * size)
    units[::2], units[1::2] = text[::4], text[1::4]
    return units.decode("utf-16-le", "replace").encode()


def strings_to_cdr(data: bytes | memoryview, position: int, count: int, target: int) -> tuple[bytes, int, int]:
    """Convert an array of strings.

    Args:
        data: the ROS 1 message.
        position: where its first string begins.
        count: number of strings.
        target: the position of the first string in CDR, or that modulo 8.

    Returns:
        The strings in CDR; the position in `data` after the last string; ``target`` after the last string.

    Raises:
        struct.error: there are too few bytes for that many strings; each has at least 4.
    """
    parts: list[bytes | memoryview] = []
    for _ in range(count):
        (size,) = _read_size(data, position)
        begin = position + 4
        position = begin + size
        parts += _SIZE_WRITERS[target & 3](size + 1), data[begin:position], b"\0"
        target += (-target & 3) + 5 + size
    return b"".join(parts), position, target


def strings_from_cdr(data: bytes | memoryview, position: int, count: int) -> tuple[bytes, int]:
    """Convert an array of strings.

    Args:
        data: the CDR message with its header.
        position: position after the number of strings.
        count: number of strings.

    Returns:
        The strings as in ROS 1; the position in `data` after the last string.

    Raises:
        struct.error: there are too few bytes for that many strings; each has at least 4.
    """
    parts: list[bytes | memoryview] = []
    for _ in range(count):
        position += -position & 3
        (size,) = _read_size(data, position)
        begin = position + 4
        position = begin + size
        length = size - (size > 0)
        parts += _write_size(length), data[begin : begin + length]
    return b"".join(parts), position
