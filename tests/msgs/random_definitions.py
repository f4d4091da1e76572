"""Random message definitions of every shape, and random messages of any class.

It needs nothing but pyros1, so that the Python of a stock installation can use it too.
"""

from __future__ import annotations

import builtins
import keyword
import random
import struct
from typing import Any, NamedTuple

from pyros1.ground.timing import Duration, Time
from pyros1.msgs.base import nested_classes
from pyros1.msgs.factory import python_name
from pyros1.msgs.spec import STRUCT_CODES

SEPARATOR = "=" * 80
BUILTINS = [*STRUCT_CODES, "string", "time", "duration"]
HEADER = "std_msgs/Header"
HEADER_TEXT = "uint32 seq\ntime stamp\nstring frame_id\n"
MAX_VALUES = 300
"""Values that one message of a type may have at most, roughly: nested arrays multiply them."""

# Names that generated code is likely to use itself, that Python gives a meaning, or that stand for one in ROS.
_NAMES = [
    *keyword.kwlist,
    *(name for name in dir(builtins) if name[0] != "_"),
    *[
        "A",
        "B",
        "a_x",
        "args",
        "array",
        "buf",
        "buff",
        "buffer",
        "cls",
        "cls_1",
        "codes",
        "copy",
        "data",
        "decode",
        "duration",
        "Duration",
        "e",
        "each",
        "encode",
        "end",
        "error",
    ],
    *[
        "header",
        "i",
        "item",
        "items",
        "kwds",
        "m",
        "m_1",
        "message",
        "mro",
        "msg",
        "n",
        "n_3",
        "new",
        "new_2",
        "nsecs",
        "numpy",
        "p",
        "p_2",
        "pack_4",
        "piece",
        "q",
        "q_3",
        "read",
    ],
    *[
        "refusal",
        "repeat",
        "secs",
        "self",
        "seq",
        "size",
        "stamp",
        "start",
        "string",
        "struct",
        "time",
        "Time",
        "uint8",
        "value",
        "values",
        "view",
        "wrong",
        "x",
        "x1",
    ],
]
# Of a class that genpy or pyros1 makes they would hide a method; genpy refuses some of them.
_TAKEN = {"serialize", "deserialize", "serialize_numpy", "deserialize_numpy"}
_CONSTANTS = {
    "bool": ["True", "False", "1", "0", "7"],
    "float": ["-2.5e-3", ".5", "5.", "1e10", "007", "-0.0", "3", "1_0.5", "1e300"],
    "string": ["", "plain", "a # b", "it's", 'say "x"', "  spaces  inside  ", "back\\slash", "a=b", "é", "'''", "0"],
}


class Definition(NamedTuple):
    """A message type and all that it uses.

    Attributes:
        name: full type name.
        fields: full type name of each type to (type as in ``_slot_types``, name) of its fields; the root comes first.
        texts: full type name to definition text.
    """

    name: str
    fields: dict[str, list[tuple[str, str]]]
    texts: dict[str, str]

    def full_text(self, name: str | None = None) -> str:
        """Return the text as connection headers carry it."""
        first = name or self.name
        return self.texts[first] + "".join(
            f"\n{SEPARATOR}\nMSG: {each}\n{self.texts[each]}" for each in self.used(first)
        )

    def used(self, name: str | None = None) -> dict[str, None]:
        """Return the types that a type uses, in the order of connection headers."""
        used: dict[str, None] = {}
        self._collect(name or self.name, used)
        return used

    def _collect(self, name: str, used: dict[str, None]) -> None:
        for slot_type, _ in self.fields[name]:
            base = slot_type.partition("[")[0]
            if base in self.fields and base not in used:
                used[base] = None
                self._collect(base, used)

    def encode(self, message: Any, name: str | None = None) -> bytes:
        """Return the encoded message, field by field, as https://wiki.ros.org/msg describes it."""
        parts = []
        for slot_type, field in self.fields[name or self.name]:
            base, bracket, count = slot_type.partition("[")
            value = getattr(message, python_name(field))
            if count == "]":
                parts.append(struct.pack("<I", len(value)))
            parts += [self._single(base, each) for each in (value if bracket else [value])]
        return b"".join(parts)

    def _single(self, base: str, value: Any) -> bytes:
        if base in STRUCT_CODES:
            return struct.pack("<" + STRUCT_CODES[base], value)
        if base == "string":
            return struct.pack("<I", len(value.encode())) + value.encode()
        if base in ("time", "duration"):
            return struct.pack("<II" if base == "time" else "<ii", value.secs, value.nsecs)
        return self.encode(value, base)


class _Maker:
    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.fields: dict[str, list[tuple[str, str]]] = {}
        self.texts: dict[str, str] = {}
        self.costs: dict[str, int] = {}

    def make(self) -> Definition:
        rng = self.rng
        shape = rng.random()
        if shape < 0.01:
            return self._finish(self._chain(rng.randint(20, 60)))
        wide = shape > 0.995
        count = 1 if wide else rng.choice([1, 1, 2, 2, 3, 4, 5, 8])
        names = [f"{rng.choice(['p', 'p', 'p', 'other_msgs'])}/T{number}" for number in range(count)]
        self._add(HEADER, [("uint32", "seq"), ("time", "stamp"), ("string", "frame_id")], HEADER_TEXT)
        for index in reversed(range(count)):
            most = 1000 if wide else rng.choice([0, 1, 1, 2, 3, 4, 6, 10, 30])
            self._type(names[index], names[index + 1 :], rng.randint(min(most, 1), most))
        return self._finish(names[0])

    def _finish(self, root: str) -> Definition:
        fields = {root: self.fields[root], **self.fields}
        return Definition(root, fields, self.texts)

    def _chain(self, depth: int) -> str:
        """Types that are nested deep, with something before and behind each."""
        for level in range(depth, -1, -1):
            inner = [(f"p/L{level + 1}" + self.rng.choice(["", "", "[]", "[1]"]), "inner")] if level < depth else []
            around = [(self.rng.choice(BUILTINS), name) for name in ("before", "behind")]
            fields = [*around[: self.rng.randint(0, 1)], *inner, *around[1 : self.rng.randint(1, 2)]]
            self._add(f"p/L{level}", fields, "".join(f"{kind} {name}\n" for kind, name in fields))
        return "p/L0"

    def _add(self, name: str, fields: list[tuple[str, str]], text: str) -> None:
        self.fields[name], self.texts[name] = fields, text
        self.costs[name] = 1 + sum(self._cost(kind) for kind, _ in fields)

    def _cost(self, slot_type: str) -> int:
        base, bracket, count = slot_type.partition("[")
        return self.costs.get(base, 1) * (1 if not bracket else 3 if count == "]" else int(count[:-1]))

    def _type(self, name: str, later: list[str], count: int) -> None:
        rng, fields, total = self.rng, [], 0
        lines = self._constants() if rng.random() < 0.3 else []
        taken: set[str] = {line.partition("=")[0].split(" ")[1] for line in lines} | _TAKEN
        for _ in range(count):
            base, suffix = self._base(later), rng.choice(["", "", "", "[]", "[]", "[1]", "[2]", "[3]", "[0]", "[300]"])
            if suffix == "[300]" and (base not in STRUCT_CODES or rng.random() < 0.9):
                suffix = "[4]"
            if base in self.costs and self.costs[base] <= 2 and suffix in ("[3]", "[4]"):
                suffix = "[2]"  # arrays of nothing may have few elements only
            if total + self._cost(base + suffix) > MAX_VALUES and count < 1000:
                continue
            field = self._field_name(taken)
            total += self._cost(base + suffix) if suffix != "[300]" else 1
            fields.append((base + suffix, field))
            lines.append(self._line(name, base, suffix, field))
            if rng.random() < 0.1:
                lines.append(rng.choice(["", "# a comment", "   ", "#", "# a = b", "# === ", "\t"]))
        if rng.random() < 0.1 and not any(field == "header" for _, field in fields) and "header" not in taken:
            fields.insert(0, (HEADER, "header"))
            lines.insert(0, rng.choice(["Header header", "std_msgs/Header header"]))
        self._add(name, fields, "\n".join(lines) + rng.choice(["", "\n", "\n\n"]))

    def _base(self, later: list[str]) -> str:
        rng = self.rng
        if later and rng.random() < 0.45:
            return rng.choice(later)
        if rng.random() < 0.03:
            return HEADER
        return rng.choice([*BUILTINS, "string", "time", "duration"])

    def _field_name(self, taken: set[str]) -> str:
        rng = self.rng
        while True:
            name = rng.choice(_NAMES) if rng.random() < 0.6 else f"f{len(taken)}_{rng.randint(0, 9)}"
            if python_name(name) not in taken and name not in taken:
                taken.update((name, python_name(name)))
                return name

    def _line(self, owner: str, base: str, suffix: str, field: str) -> str:
        rng = self.rng
        package = owner.partition("/")[0]
        if base.partition("/")[0] == package and rng.random() < 0.5:
            base = base.partition("/")[2]
        if suffix[1:-1].isdigit() and rng.random() < 0.05:
            suffix = f"[0{suffix[1:]}"
        return f"{base}{suffix}{rng.choice([' ', ' ', '  '])}{field}{rng.choice(['', '', ' ', ' # why', '#x'])}"

    def _constants(self) -> list[str]:
        rng, lines = self.rng, []
        for number in range(rng.randint(1, 4)):
            kind = rng.choice([*STRUCT_CODES, "string"])
            family = "float" if kind.startswith("float") else kind
            known = _CONSTANTS.get(family)
            value = rng.choice(known) if known is not None else rng.choice(["0", "007", "+5", "1", "1_2", "-0", "00"])
            if kind == "float32" and value == "1e300":
                value = "1e30"
            comment = " # why" if kind != "string" and rng.random() < 0.2 else ""
            lines.append(f"{kind} C{number}{rng.choice(['=', ' = ', '= '])}{value}{comment}")
        return lines


def random_definition(rng: random.Random) -> Definition:
    """Return a definition that genpy takes, too."""
    return _Maker(rng).make()


def random_message(rng: random.Random, cls: Any) -> Any:
    """Return a message of a class, its values as decoding gives them."""
    return cls(*(_field(rng, cls, slot_type) for slot_type in cls._slot_types))


def _field(rng: random.Random, cls: Any, slot_type: str) -> Any:
    base, bracket, count = slot_type.partition("[")
    if not bracket:
        return _single(rng, cls, base)
    length = rng.choice([0, 1, 2, 3]) if count == "]" else int(count[:-1])
    if count == "]" and base in STRUCT_CODES and rng.random() < 0.02:
        length = 300
    if STRUCT_CODES.get(base) == "B" and base != "bool":
        return bytes(rng.randrange(256) for _ in range(length))
    values = [_single(rng, cls, base) for _ in range(length)]
    return tuple(values) if base in STRUCT_CODES and base != "bool" else values


def _single(rng: random.Random, cls: Any, base: str) -> Any:  # noqa: PLR0911  one per kind of type
    code = STRUCT_CODES.get(base)
    if base == "bool":
        return rng.random() < 0.5
    if code is not None and code in "fd":
        value = rng.choice([0.0, -1.5, 1e-7, float("inf"), rng.uniform(-1e6, 1e6)])
        return struct.unpack("<" + code, struct.pack("<" + code, value))[0]
    if code is not None:
        bits = 8 * struct.calcsize("<" + code)
        low = -(1 << bits - 1) if code.islower() else 0
        return rng.choice([low, low + (1 << bits) - 1, rng.randrange(low, low + (1 << bits))])
    if base == "string":
        return "".join(rng.choice("aB ü\n#:😀0-'\"") for _ in range(rng.choice([0, 0, 1, 3, 9, 9, 300])))
    if base == "time":
        return Time(rng.choice([0, 2**32 - 1, rng.randrange(2**32)]), rng.randrange(10**9))
    if base == "duration":
        return Duration(rng.choice([-(2**31), 0, 2**31 - 1]), rng.randrange(10**9))
    return random_message(rng, nested_classes(cls)[base])
