"""Functions called by the generated codecs: arrays of bytes, numbers, strings and times; lists of buffers."""

from __future__ import annotations

import struct
import sys
from collections.abc import Callable, Sequence
from typing import Any

from pyros1.ground.timing import TVal
from pyros1.msgs.base import Buffer

LARGE_STRING_SIZE = 1 << 20
"""Minimum size in bytes of strings that are decoded without copying their bytes; for short ones, this is slower."""

_MAX_CACHED_LENGTH = 256
_U32 = struct.Struct("<I")
_unpack_u32 = _U32.unpack_from
_LENGTH_PREFIXES = tuple(_U32.pack(size) for size in range(256))


class Packers(dict[int, Callable[..., bytes]]):
    """Dictionary: array length -> function that packs that many numbers; only functions for short arrays are cached."""

    def __init__(self, code: str) -> None:
        super().__init__()
        self._code = code

    def __missing__(self, count: int) -> Callable[..., bytes]:
        function = struct.Struct(f"<{count}{self._code}").pack
        if count <= _MAX_CACHED_LENGTH:
            self[count] = function
        return function

    def pack(self, values: Any) -> bytes:
        """Pack a long array: element by element, or all at once if its buffer already has the right format (array,
        numpy).
        """
        if not isinstance(values, (list, tuple)) and sys.byteorder == "little":
            try:
                view = memoryview(values)
            except TypeError:
                pass
            else:
                is_compatible = view.format in _COMPATIBLE_CODES.get(self._code, self._code)
                if is_compatible and view.ndim == 1 and view.itemsize == struct.calcsize("<" + self._code):
                    return view.tobytes()
        return self[len(values)](*values)


class BoolPackers(Packers):
    """Packers for booleans, including numpy's."""

    def pack(self, values: Any) -> bytes:
        """Pack an array of any length."""
        try:
            return super().pack(values)
        except struct.error:
            return super().pack(list(map(to_bool, values)))


# Buffer formats equivalent to a struct code; the code of 8-byte integers depends on the platform.
_COMPATIBLE_CODES = {"q": "ql", "Q": "QL", "B": "B?"}


class Unpackers(dict[int, Callable[[Buffer, int], tuple[Any, ...]]]):
    """Dictionary: array length -> function that unpacks that many numbers; only those for short arrays are cached."""

    def __init__(self, code: str) -> None:
        super().__init__()
        self._code = code

    def __missing__(self, count: int) -> Callable[[Buffer, int], tuple[Any, ...]]:
        function = struct.Struct(f"<{count}{self._code}").unpack_from
        if count <= _MAX_CACHED_LENGTH:
            self[count] = function
        return function


def as_bytes(value: Any, length: int) -> bytes:
    """Convert the value of a uint8[] or char[] field to bytes.

    Args:
        value: list or tuple of ints, or a buffer of single bytes, which is copied since it might change before it is
            sent.
        length: the field's fixed length, or -1 for any.

    Raises:
        TypeError, ValueError: the value has another type, or the wrong length.
    """
    if isinstance(value, (list, tuple)):
        if length >= 0 and len(value) != length:
            raise ValueError("wrong length")
        return bytes(value)
    view = memoryview(value)
    if view.itemsize != 1:  # ambiguous: the bytes of its numbers, or each number as one byte?
        raise TypeError("it is an array of numbers other than uint8: pass its tobytes(), or convert it")
    return view.tobytes()


def to_bool(value: Any) -> Any:
    """Convert a numpy boolean, which struct does not accept, to a bool; return other values unchanged."""
    return bool(value) if getattr(getattr(value, "dtype", None), "kind", "") == "b" else value


def pack_strings(values: Sequence[str]) -> bytes:
    """Encode the elements of a string array, each preceded by its length."""
    encoded_texts = list(map(str.encode, values))
    try:
        return b"".join([_LENGTH_PREFIXES[len(encoded_text)] + encoded_text for encoded_text in encoded_texts])
    except IndexError:
        return b"".join(
            [part for encoded_text in encoded_texts for part in (_U32.pack(len(encoded_text)), encoded_text)]
        )


def read_large_string(buffer: Buffer, begin: int, end: int) -> str:
    """Decode the string from ``begin`` to ``end`` without copying its bytes."""
    return str(memoryview(buffer)[begin:end], "utf-8")


def read_strings(buffer: bytes, position: int, count: int, end: int) -> tuple[list[str], int]:
    """Return a list of ``count`` strings, and the position after them.

    Raises:
        ValueError: there are too few bytes for that many strings, or a string is not UTF-8.
        struct.error: the buffer is too short.
    """
    if count > (end - position) // 4:
        raise ValueError("count")
    result = []
    for _ in range(count):
        (size,) = _unpack_u32(buffer, position)
        position += 4
        end_of_text = position + size
        text = (
            buffer[position:end_of_text].decode()
            if size < LARGE_STRING_SIZE
            else read_large_string(buffer, position, end_of_text)
        )
        result.append(text)
        position = end_of_text
    return result, position


def pack_times(values: Sequence[Any], code: str) -> bytes:
    """Encode an array of times or durations; ``code`` is the struct code for seconds and nanoseconds."""
    numbers = [number for value in values for number in (value.secs, value.nsecs)]
    return struct.pack(f"<{len(numbers)}{code}", *numbers)


def read_times(buffer: Buffer, position: int, count: int, code: str, cls: type[TVal]) -> list[TVal]:
    """Return a list of ``count`` times or durations; the caller must have checked that there are enough bytes."""
    numbers = struct.unpack_from(f"<{2 * count}{code}", buffer, position)
    result = []
    for secs, nsecs in zip(numbers[::2], numbers[1::2], strict=True):
        value = cls.__new__(cls)
        value.secs, value.nsecs = secs, nsecs
        result.append(value)
    return result


def coalesce(parts: Sequence[bytes], large_size: int) -> Any:
    """Join the small parts of a frame; parts of ``large_size`` bytes or more are unchanged.

    Returns:
        The list of buffers to send, in order; if there is only one, that buffer itself.
    """
    result: list[bytes | memoryview] = []
    small_parts: list[bytes] = []
    for part in parts:
        if len(part) < large_size:
            small_parts.append(part)
        else:
            if small_parts:
                result.append(b"".join(small_parts))
                small_parts = []
            result.append(part)
    if small_parts:
        last_part = b"".join(small_parts)
        if last_part:
            result.append(last_part)
    return result if len(result) > 1 else result[0]
