"""Random pairs of ROS 1 and ROS 2 types with values, and a slow codec for them, one value at a time."""

from __future__ import annotations

import random
import struct
from dataclasses import dataclass, field
from typing import Any

from pyros1.msgs import spec as ros1
from pyros1.ros2_types import model as ros2

_NUMBERS = [("int8", "uint8", "b"), ("byte", "byte", "b"), ("char", "uint8", "B"), ("uint8", "int8", "B")] + [
    (name, name, code) for name, code in ros2.STRUCT_CODES.items() if name != "byte"
]


@dataclass
class Kind:
    """The type of an element: a number with its struct code, ``time``, ``string``, ``wstring`` or ``record``."""

    name: str
    base1: str
    base2: str
    code: str = ""
    record: RecordPair | None = None


@dataclass
class FieldPair:
    """A field; a length is None for a single value, -1 for any number of elements."""

    name: str
    kind: Kind
    length1: int | None
    length2: int | None
    bound: int
    in1: bool
    in2: bool


@dataclass
class RecordPair:
    """Two types; the fields of the second may have another order."""

    name: str
    fields1: list[FieldPair]
    fields2: list[FieldPair]


@dataclass
class TypePair:
    """A random pair of types, its definitions included."""

    randoms: random.Random
    specs: dict[str, ros1.MessageSpec] = field(default_factory=dict)
    types: dict[str, ros2.MessageType] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.types["x/msg/Time"] = ros2.MessageType(
            "x/msg/Time",
            (ros2.Field("sec", ros2.FieldType("int32")), ros2.Field("nanosec", ros2.FieldType("uint32"))),
        )
        self.root = self._record(0)

    def _record(self, depth: int) -> RecordPair:
        fields = [self._field(f"f{index}", depth) for index in range(self.randoms.choice([0, 1, 2, 3, 4, 6]))]
        fields1 = [pair for pair in fields if pair.in1]
        fields2 = [pair for pair in fields if pair.in2]
        if self.randoms.random() < 0.25:
            self.randoms.shuffle(fields2)
        name = f"R{len(self.specs)}"
        self.specs[f"x/{name}"] = ros1.MessageSpec(
            f"x/{name}",
            tuple(ros1.Field(pair.name, pair.kind.base1, pair.length1, _brackets(pair.length1)) for pair in fields1),
            (),
            "",
        )
        types = []
        for pair in fields2:
            length = ros2.Length.SINGLE if pair.length2 is None else ros2.Length.FIXED
            if pair.length2 == -1:
                length = ros2.Length.BOUNDED if pair.bound else ros2.Length.UNBOUNDED
            size = pair.bound if pair.length2 == -1 else pair.length2 or 0
            types.append(ros2.Field(pair.name, ros2.FieldType(pair.kind.base2, length, size)))
        self.types[f"x/msg/{name}"] = ros2.MessageType(f"x/msg/{name}", tuple(types))
        return RecordPair(name, fields1, fields2)

    def _field(self, name: str, depth: int) -> FieldPair:
        choose = self.randoms.choice
        what = choose(["number"] * 5 + ["time", "string", "string", "wstring"] + ["record"] * (3 * (depth < 3)))
        if what == "number":
            base1, base2, code = choose(_NUMBERS)
            kind = Kind("number", base1, base2, code)
        elif what == "record":
            record = self._record(depth + 1)
            kind = Kind("record", f"x/{record.name}", f"x/msg/{record.name}", record=record)
        else:
            kind = Kind(what, "time" if what == "time" else "string", "x/msg/Time" if what == "time" else what)
        side = choose(["both"] * 6 + ["1", "2"])
        fixed = choose([1, 2, 3, 9, 12])
        length1, length2, bound = choose(
            [(None, None, 0)] * 4 + [(-1, -1, 0)] * 4 + [(fixed, fixed, 0), (-1, fixed, 0), (fixed, -1, 0), (-1, -1, 4)]
        )
        if kind.record and not (kind.record.fields1 and kind.record.fields2) and length1 is not None:
            length1 = length2 = -1  # arrays of empty messages are limited
        return FieldPair(name, kind, length1, length2, bound, side != "2", side != "1")

    def value(self, side: int, record: RecordPair | None = None) -> dict[str, Any]:
        """Return a random message: the fields of one side, 1 or 2."""
        record = record or self.root
        result = {}
        for pair in record.fields1 if side == 1 else record.fields2:
            lengths = [length for length in (pair.length1, pair.length2) if length not in (None, -1)]
            if pair.length1 is None:
                result[pair.name] = self._element(side, pair.kind)
            else:
                count = lengths[0] if lengths else self.randoms.randrange((pair.bound or 5) + 1)
                result[pair.name] = [self._element(side, pair.kind) for _ in range(count or 0)]
        return result

    def _element(self, side: int, kind: Kind) -> Any:
        randoms = self.randoms
        if kind.record is not None:
            return self.value(side, kind.record)
        if kind.name == "time":
            return randoms.getrandbits(31), randoms.getrandbits(32)
        if kind.name == "string":
            return randoms.randbytes(randoms.choice([0, 1, 3, 4, 7, 8, 20]))
        if kind.name == "wstring":
            return "".join(randoms.choices("az\0ä€😀", k=randoms.randrange(6))).encode()
        return randoms.randrange(2) if kind.code == "?" else randoms.randrange(100)


def _brackets(length: int | None) -> str:
    return "" if length is None else "[]" if length < 0 else f"[{length}]"


@dataclass
class Writer:
    """Encodes a message.

    Attributes:
        side: 1 for ROS 1, 2 for CDR.
        order: byte order as in struct formats.
        filler: value of padding bytes.
    """

    side: int
    order: str = "<"
    filler: int = 0
    data: bytearray = field(default_factory=bytearray)

    def message(self, record: RecordPair, value: dict[str, Any]) -> bytes:
        """Return the encoded message; fields without a value are zero or empty."""
        self._record(record, value)
        if self.side == 1:
            return bytes(self.data)
        return (b"\0\1\0\0" if self.order == "<" else b"\0\0\0\0") + self.data

    def _number(self, code: str, value: Any) -> None:
        encoded = struct.pack(self.order + code, value)
        while self.side == 2 and len(self.data) % len(encoded):
            self.data.append(self.filler)
        self.data += encoded

    def _record(self, record: RecordPair, value: dict[str, Any]) -> None:
        fields = record.fields1 if self.side == 1 else record.fields2
        for pair in fields:
            length = pair.length1 if self.side == 1 else pair.length2
            if length is None:
                self._element(pair.kind, value.get(pair.name))
                continue
            elements = value.get(pair.name, [None] * max(length, 0))
            if length < 0:
                self._number("I", len(elements))
            for element in elements:
                self._element(pair.kind, element)
        if self.side == 2 and not fields:
            self._number("B", 0)

    def _element(self, kind: Kind, value: Any) -> None:
        if kind.record is not None:
            self._record(kind.record, value or {})
        elif kind.name == "time":
            for number in value or (0, 0):
                self._number("I", number)
        elif kind.name == "wstring" and self.side == 2:
            units = (value or b"").decode().encode("utf-16-le")
            self._number("I", len(units) // 2)
            for (unit,) in struct.iter_unpack("<H", units):
                self._number("I", unit)
        elif kind.name in ("string", "wstring"):
            text = (value or b"") + (b"\0" if self.side == 2 else b"")
            self._number("I", len(text))
            self.data += text
        else:
            self._number(kind.code, value or 0)
