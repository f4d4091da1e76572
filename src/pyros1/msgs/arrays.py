"""Helpers of generated codecs: arrays of bytes, numbers, strings and times, and buffer lists."""

from __future__ import annotations

import struct
import sys
from collections.abc import Callable, Sequence
from typing import Any

from pyros1.ground.timing import TVal
from pyros1.msgs.base import Buffer

LARGE_STRING = 1 << 20
"""Size in bytes from which strings are decoded without a copy of their bytes, which takes longer for short ones."""

_MAX_CACHED_LENGTH = 256
_U32 = struct.Struct("<I")
_unpack_u32 = _U32.unpack_from
_PREFIXES = tuple(_U32.pack(size) for size in range(256))


class Packers(dict[int, Callable[..., bytes]]):
    """Number of elements -> function that packs that many numbers; only those for short arrays are kept."""

    def __init__(self, code: str) -> None:
        super().__init__()
        self._code = code

    def __missing__(self, count: int) -> Callable[..., bytes]:
        function = struct.Struct(f"<{count}{self._code}").pack
        if count <= _MAX_CACHED_LENGTH:
            self[count] = function
        return function

    def pack(self, values: Any) -> bytes:
        """Pack a long array: element by element, or as a whole if it holds such numbers already (array, numpy)."""
        if not isinstance(values, (list, tuple)) and sys.byteorder == "little":
            try:
                view = memoryview(values)
            except TypeError:
                pass
            else:
                same = view.format in _COMPATIBLE_CODES.get(self._code, self._code)
                if same and view.ndim == 1 and view.itemsize == struct.calcsize("<" + self._code):
                    return view.tobytes()
        return self[len(values)](*values)


class BoolPackers(Packers):
    """The same for booleans, numpy's included."""

    def pack(self, values: Any) -> bytes:
        """Pack an array of any length."""
        try:
            return super().pack(values)
        except struct.error:
            return super().pack(list(map(to_bool, values)))


# Buffer formats with the same bytes as a struct code: the name of an 8-byte integer depends on the platform.
_COMPATIBLE_CODES = {"q": "ql", "Q": "QL", "B": "B?"}


class Unpackers(dict[int, Callable[[Buffer, int], tuple[Any, ...]]]):
    """Number of elements -> function that unpacks that many numbers; only those for short arrays are kept."""

    def __init__(self, code: str) -> None:
        super().__init__()
        self._code = code

    def __missing__(self, count: int) -> Callable[[Buffer, int], tuple[Any, ...]]:
        function = struct.Struct(f"<{count}{self._code}").unpack_from
        if count <= _MAX_CACHED_LENGTH:
            self[count] = function
        return function


def octets(value: Any, length: int) -> bytes:
    """Return the value of a uint8[] or char[] field, which is not bytes yet, as bytes.

    Args:
        value: list or tuple of ints, or a buffer of single bytes. It is copied, since it may change before it is sent.
        length: the field's fixed length, or -1.

    Raises:
        TypeError, ValueError: the value is of another kind, or has the wrong length.
    """
    if isinstance(value, (list, tuple)):
        if length >= 0 and len(value) != length:
            raise ValueError("wrong length")
        return bytes(value)
    view = memoryview(value)
    if view.itemsize != 1:  # the bytes of its numbers, or its numbers as bytes? Each would be wrong for some programs
        raise TypeError("it is an array of other numbers than uint8: give its tobytes(), or convert it")
    return view.tobytes()


def to_bool(value: Any) -> Any:
    """Return the boolean of numpy, which struct does not accept, as Python's; other values unchanged."""
    return bool(value) if getattr(getattr(value, "dtype", None), "kind", "") == "b" else value


def pack_strings(values: Sequence[str]) -> bytes:
    """Return the encoded elements of a string array, each with its length in front."""
    encoded = list(map(str.encode, values))
    try:
        return b"".join([_PREFIXES[len(text)] + text for text in encoded])
    except IndexError:
        return b"".join([part for text in encoded for part in (_U32.pack(len(text)), text)])


def read_large_string(buffer: Buffer, begin: int, end: int) -> str:
    """Return the string from ``begin`` to ``end``, without a copy of its bytes."""
    return str(memoryview(buffer)[begin:end], "utf-8")


def read_strings(buffer: bytes, position: int, count: int, end: int) -> tuple[list[str], int]:
    """Return a list of ``count`` strings, and the position behind them.

    Raises:
        ValueError: the remaining bytes cannot hold that many strings, or are not UTF-8.
        struct.error: the buffer is too short.
    """
    if count > (end - position) // 4:
        raise ValueError("count")
    result = []
    for _ in range(count):
        (size,) = _unpack_u32(buffer, position)
        position += 4
        stop = position + size
        text = buffer[position:stop].decode() if size < LARGE_STRING else read_large_string(buffer, position, stop)
        result.append(text)
        position = stop
    return result, position


def pack_times(values: Sequence[Any], code: str) -> bytes:
    """Return the encoded elements of an array of times or durations; ``code`` is the struct code of both parts."""
    numbers = [number for value in values for number in (value.secs, value.nsecs)]
    return struct.pack(f"<{len(numbers)}{code}", *numbers)


def read_times(buffer: Buffer, position: int, count: int, code: str, cls: type[TVal]) -> list[TVal]:
    """Return a list of ``count`` times or durations; the caller has checked that they fit."""
    numbers = struct.unpack_from(f"<{2 * count}{code}", buffer, position)
    result = []
    for secs, nsecs in zip(numbers[::2], numbers[1::2], strict=True):
        value = cls.__new__(cls)
        value.secs, value.nsecs = secs, nsecs
        result.append(value)
    return result


def coalesce(parts: Sequence[bytes], large: int) -> Any:
    """Return a frame's parts as buffers to send in order: those of ``large`` bytes or more unchanged, others joined."""
    result: list[bytes | memoryview] = []
    small: list[bytes] = []
    for part in parts:
        if len(part) < large:
            small.append(part)
        else:
            if small:
                result.append(b"".join(small))
                small = []
            result.append(part)
    if small:
        rest = b"".join(small)
        if rest:
            result.append(rest)
    return result if len(result) > 1 else result[0]
