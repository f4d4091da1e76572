"""Changes the byte order of big-endian CDR. Only big-endian machines send it, so this need not be fast."""

from __future__ import annotations

import struct

from pyros1.ground.errors import MessageError
from pyros1.ros2_types.model import STRUCT_CODES, Field, FieldType, Length, Types
from pyros1.ros2_types.transcoding.layout import aligned
from pyros1.ros2_types.transcoding.plan import FILLER

_FILLER_FIELDS = (Field(FILLER, FieldType("uint8")),)
_LITTLE_ENDIAN = b"\0\1\0\0"


def to_little_endian(data: bytes | memoryview, name: str, types: Types) -> bytes:
    """Return a message in little-endian CDR, with its header.

    Args:
        data: the message in big-endian CDR, with its header.
        name: its type.
        types: that type and all types that it uses; no type may contain itself.

    Raises:
        MessageError: the message is too short.
    """
    swapper = _Swapper(bytearray(data[len(_LITTLE_ENDIAN) :]), types)
    swapper.message(name)
    return _LITTLE_ENDIAN + swapper.data


class _Swapper:
    def __init__(self, data: bytearray, types: Types) -> None:
        self.data = data
        self._types = types
        self._position = 0

    def message(self, name: str) -> None:
        for field in self._types[name].fields or _FILLER_FIELDS:
            self._field(field.type)

    def _field(self, field_type: FieldType) -> None:
        base, length, size, _ = field_type
        if length is Length.SINGLE:
            count = 1
        elif length is Length.FIXED:
            count = size
        else:
            count = self._count()
        if base in STRUCT_CODES:
            self._numbers(struct.calcsize("<" + STRUCT_CODES[base]), count)
            return
        for _ in range(count):  # each element has at least one byte, so a wrong count soon fails
            if base == "string":
                self._numbers(1, self._count())
            elif base == "wstring":
                self._numbers(4, self._count())
            else:
                self.message(base)

    def _count(self) -> int:
        self._numbers(4, 1)
        return int.from_bytes(self.data[self._position - 4 : self._position], "little")

    def _numbers(self, width: int, count: int) -> None:
        if not count:
            return
        begin = aligned(self._position, width)
        end = self._position = begin + width * count
        if end > len(self.data):
            raise MessageError("it ends too early")
        if width > 1:
            source = bytes(self.data[begin:end])
            for index in range(width):
                self.data[begin + index : end : width] = source[width - 1 - index :: width]
