"""What must hold for a message class made from any definition, whatever its shape; see ``test_random_definitions.py``.

By hand, with as many definitions as wanted::

    python tests/msgs/definition_checks.py FIRST_SEED COUNT
"""

from __future__ import annotations

import math
import random
import struct
import sys
from pathlib import Path
from typing import Any

import codec
import numpy
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

sys.path.insert(0, str(Path(__file__).parent))

from random_definitions import (
    SEPARATOR,
    Definition,
    random_definition,
    random_message,
)

from pyros1.ground.errors import DefinitionError, DeserializationError, LengthError, SerializationError
from pyros1.ground.timing import TVal
from pyros1.msgs import Message, from_definition
from pyros1.msgs.array_views import make_numpy_view, memoryview_view
from pyros1.msgs.base import nested_classes
from pyros1.msgs.factory import MAX_EMPTY_MESSAGES
from pyros1.msgs.generator import TIME_CLASSES, split_type
from pyros1.msgs.json_form import from_json, to_json
from pyros1.msgs.large_arrays import SplitBody, decode_split, find_layout, split_frame
from pyros1.msgs.spec import STRUCT_CODES

VIEWS = {
    "numpy": make_numpy_view(numpy),
    "records": make_numpy_view(numpy, records=True),
    "memoryview": memoryview_view,
}


def check(seed: int, cuts: int = 8) -> None:
    """Check all for one random definition.

    Args:
        seed: which one.
        cuts: at how many lengths the encoded message is cut.

    Raises:
        AssertionError: something does not hold. Any other exception is a fault as well.
    """
    rng = random.Random(seed)
    definition = random_definition(rng)
    if most_empty(definition) > MAX_EMPTY_MESSAGES:
        with pytest.raises(DefinitionError, match="messages without content; the limit is"):
            from_definition(definition.name, definition.full_text())
        return
    cls: Any = from_definition(definition.name, definition.full_text())
    message = random_message(rng, cls)
    body = codec.encode(message)
    assert body == definition.encode(message), "bytes"
    frame = codec.encode_frame(message)
    assert (frame if isinstance(frame, bytes) else b"".join(frame)) == struct.pack("<I", len(body)) + body, "frame"
    check_texts(definition, cls)
    check_rosbags(definition, cls, message, body)
    check_decoding(cls, message, body)
    check_defaults(cls)
    check_large(cls, message, body)
    check_wrong_bytes(cls, body, rng, cuts)
    check_wrong_lengths(cls, message)
    assert codec.encode(from_json(cls, to_json(message))) == body, "JSON"
    str(message)


def most_empty(definition: Definition) -> int:
    """Return how many messages the field has that has most of them and takes no bytes."""
    sizes = {}  # full type name: (least bytes, messages)
    most = 0
    used = {definition.name, *definition.used()}
    root, *others = definition.fields.items()
    for name, fields in (*others, root):  # each after those that it uses
        if name not in used:
            continue
        least, messages = 0, 1
        for slot_type, _ in fields:
            base, bracket, count = slot_type.partition("[")
            size, inside = sizes.get(base, (1, 0))
            number = int(count[:-1]) if bracket and count != "]" else 1
            size, inside = (1, 0) if count == "]" else (size * number, inside * number)
            if size == 0:
                most = max(most, inside)
            least, messages = least + size, messages + inside
        sizes[name] = least, messages
    return most


def check_texts(definition: Definition, cls: Any) -> None:
    """Full texts of the type and of those in it."""
    assert cls._full_text == definition.full_text()
    pending = [cls]
    while pending:
        each = pending.pop()
        pending += nested_classes(each).values()
        assert each._full_text == definition.full_text(each._type), f"full text of {each._type}"


def check_decoding(cls: Any, message: Any, body: bytes) -> None:
    """Decoding in all its ways, and copying: the same values of the same types."""
    padded = b"abc" + body + b"d" * 40
    for buffer, start in ((body, 0), (padded, 3)):
        assert_same(codec.decode(cls, buffer, start, start + len(body)), message)
    for buffer in (padded[3:], memoryview(padded)[3:]):
        assert_same(cls().deserialize(buffer), message)
    read, end = codec.read(cls, padded, 3, len(padded))
    assert end == 3 + len(body), "end"
    assert_same(read, message)
    copy = codec.copy(message)
    assert_same(copy, message)
    assert not {*map(id, mutable_parts(message))} & {*map(id, mutable_parts(copy))}, "shared with the copy"
    wanted = plain(message)
    for view in VIEWS.values():
        for buffer, start in ((body, 0), (padded, 3)):
            decoded = codec.decode_arrays(cls, buffer, start, start + len(body), view)
            assert_same(plain(decoded), wanted)
            if view is not VIEWS["memoryview"]:
                assert codec.encode(decoded) == body, "arrays encoded"
                assert_same(codec.copy(decoded), message)
        decoded, end = codec.read_arrays(cls, padded, 3, len(padded), view)
        assert end == 3 + len(body), "end"
        assert_same(plain(decoded), wanted)


def check_defaults(cls: Any) -> None:
    """The three ways to make a message."""
    message = cls()
    body = codec.encode(message)
    assert not any(body), "defaults"
    assert plain(codec.decode(cls, body, 0, len(body))) == plain(message), "defaults decoded"
    values = [getattr(message, name) for name in cls.__slots__]
    if values:
        assert (
            cls(*values)
            == cls(**dict(zip(cls.__slots__, values, strict=True)))
            == message
            == cls(*[None] * len(values))
        )


def check_large(cls: Any, message: Any, body: bytes) -> None:
    """The path of messages that are large because of one array of bytes."""
    where = find_layout(cls)
    if where is None:
        return
    size = len(getattr(message, where.field))
    begin = len(body) - where.tail_size - size
    split = SplitBody(body[: begin - 4], body[begin : begin + size], body[begin + size :])
    assert split.join() == body
    assert_same(decode_split(cls, where, split), message)
    for view in VIEWS.values():
        assert_same(plain(decode_split(cls, where, split, view)), plain(message))
    large = codec.copy(message)
    setattr(large, where.field, bytes(range(256)) * 80)
    frame = codec.encode_frame(large)
    pieces = split_frame(frame, where.tail_size)
    assert pieces is not None and b"".join(frame)[4:] == codec.encode(large) == pieces.join()
    assert_same(decode_split(cls, where, pieces), large)


def check_wrong_bytes(cls: Any, body: bytes, rng: random.Random, cuts: int) -> None:
    """Bytes that are cut, too many, or changed: the documented error, or a value; all decoders agree."""
    lengths = range(len(body)) if len(body) <= cuts else sorted(rng.sample(range(len(body)), cuts))
    for cut in lengths:
        for buffer in (body[:cut], body):  # the bytes may lie in the buffer: what counts is the end given
            assert not accepted(cls, buffer, cut, exact=True), f"cut at {cut}"
    assert not accepted(cls, body + b"x", len(body) + 1, exact=True), "too long"
    assert accepted(cls, body + b"x", len(body) + 1), "bytes behind"
    for _ in range(min(len(body), 4)):
        changed = bytearray(body)
        changed[rng.randrange(len(body))] = rng.choice([0, 1, 255, rng.randrange(256)])
        if accepted(cls, bytes(changed), len(body)):
            decoded = codec.decode(cls, bytes(changed), 0, len(body))
            try:
                again = codec.encode(decoded)
            except SerializationError as error:  # nanoseconds beyond a second can carry the seconds out of their range
                assert (
                    str(error).partition(" exceeds")[2].startswith((" specified width [time]", " specified width [dur"))
                )
                continue
            assert_same(codec.decode(cls, again, 0, len(again)), decoded, nan=True)


def accepted(cls: Any, buffer: bytes, end: int, *, exact: bool = False) -> bool:
    """Whether the decoders take the bytes; they must agree. If exact, the bytes must be those of the message only."""
    results = []
    for view in (None, *VIEWS.values()):
        try:
            if view is None:
                codec.decode(cls, buffer, 0, end, exact=exact)
            else:
                codec.decode_arrays(cls, buffer, 0, end, view, exact=exact)
        except LengthError:
            results.append(False)
        except DeserializationError as error:
            assert error.type_name == cls._type and 0 <= error.offset <= end, "error"
            results.append(False)
        else:
            results.append(True)
    assert len(set(results)) == 1, "decoders disagree"
    return results[0]


def check_wrong_lengths(cls: Any, message: Any) -> None:
    """An element too many in an array of a fixed length."""
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        base, _, count = slot_type.partition("[")
        if not count or count == "]":
            continue
        value = getattr(message, name)
        one = (
            b"x"
            if STRUCT_CODES.get(base) == "B" and base != "bool"
            else [nested_classes(cls)[base]() if "/" in base else 0]
        )
        setattr(message, name, value + (tuple(one) if isinstance(value, tuple) else one))
        for function in (codec.encode, codec.encode_frame, codec.copy):
            with pytest.raises(SerializationError, match=f"^field {name} has {len(value) + 1} (elements|bytes)"):
                function(message)
        setattr(message, name, value)


# rosbags ------------------------------------------------------------------------------------------------------------


def check_rosbags(definition: Definition, cls: Any, message: Any, body: bytes) -> None:
    """The rosbags library encodes the same values to the same bytes, and gives the plain definition the same md5.

    It reads fewer constants and field names than ROS does, and takes [0] for []: so it gets a definition without
    constants and arrays of nothing, with other names.
    """
    texts = {
        name: "".join(f"{slot_type} f{number}\n" for number, (slot_type, _) in enumerate(fields) if _known(slot_type))
        for name, fields in definition.fields.items()
    }
    used = definition.full_text().split(f"\n{SEPARATOR}\nMSG: ")[1:]
    names = [part.partition("\n")[0] for part in used]
    text = texts[definition.name] + "".join(f"{SEPARATOR}\nMSG: {name}\n{texts[name]}" for name in names)
    store = get_typestore(Stores.EMPTY)
    name = definition.name.replace("/", "/msg/")
    store.register(get_types_from_msg(text, name))
    assert from_definition(definition.name, text)._md5sum == store.generate_msgdef(name, ros_version=1)[1], "md5"
    assert store.serialize_ros1(_theirs(store, cls, message), name) == body, "rosbags' bytes"


def _known(slot_type: str) -> bool:
    return split_type(slot_type)[1] != 0


def _theirs(store: Any, cls: Any, message: Any) -> Any:
    name = cls._type.replace("/", "/msg/")
    values = [
        _their_field(store, cls, slot_type, getattr(message, field))
        for field, slot_type in zip(cls.__slots__, cls._slot_types, strict=True)
        if _known(slot_type)
    ]
    return store.types[name](*(values or [0]))  # an empty message has a field there


def _their_field(store: Any, cls: Any, slot_type: str, value: Any) -> Any:
    base, bracket, _ = slot_type.partition("[")
    if bracket:
        if base in STRUCT_CODES:
            return numpy.array(list(value), "?" if base == "bool" else "<" + STRUCT_CODES[base])
        return [_their_field(store, cls, base, each) for each in value]
    if isinstance(value, TVal):
        secs = (value.secs + (1 << 31)) % (1 << 32) - (1 << 31)  # it knows ROS 2's times, which are signed
        return store.types[f"builtin_interfaces/msg/{base.capitalize()}"](secs, value.nsecs)
    nested = nested_classes(cls).get(base)
    return value if nested is None else _theirs(store, nested, value)


# Values -------------------------------------------------------------------------------------------------------------


def plain(value: Any) -> Any:
    """A message as nested lists, whatever its arrays are."""
    if isinstance(value, Message):
        classes = nested_classes(type(value))
        bases = [split_type(slot_type)[0] for slot_type in value._slot_types]
        values = [getattr(value, name) for name in type(value).__slots__]
        return [
            plain_records(each, classes[base]) if isinstance(each, numpy.recarray) else plain(each)
            for base, each in zip(bases, values, strict=True)
        ]
    if isinstance(value, (numpy.ndarray, memoryview)):
        assert not (value.flags.writeable if isinstance(value, numpy.ndarray) else not value.readonly) or not len(value)
        return value.tolist()
    return [plain(each) for each in value] if isinstance(value, (list, tuple, bytes)) else value


def plain_records(records: Any, cls: Any) -> list[Any]:
    """The elements of an array of messages as nested lists, read by the names of the fields."""
    assert not records.flags.writeable or not len(records)
    return [plain_record(record, cls) for record in records]


def plain_record(record: Any, cls: Any) -> list[Any]:
    fields = []
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        base, length = split_type(slot_type)
        values = [record[name]] if length is None else list(record[name])
        if base in ("time", "duration"):
            elements: list[Any] = [TIME_CLASSES[base](int(value["secs"]), int(value["nsecs"])) for value in values]
        elif base in STRUCT_CODES:
            elements = [value.item() for value in values]
        else:
            elements = [plain_record(value, nested_classes(cls)[base]) for value in values]
        fields.append(elements[0] if length is None else elements)
    return fields


def mutable_parts(message: Any) -> list[Any]:
    """All lists, times and messages in a message."""
    found, pending = [], [message]
    while pending:
        value = pending.pop()
        if isinstance(value, Message):
            pending += [getattr(value, name) for name in type(value).__slots__]
        elif isinstance(value, list):
            pending += value
        elif not isinstance(value, TVal):
            continue
        found.append(value)
    return found


def assert_same(mine: Any, wanted: Any, *, nan: bool = False) -> None:
    """Fail unless two values are equal and of the same types, all the way down.

    Args:
        nan: whether two numbers that are none count as equal.
    """
    assert type(mine) is type(wanted), f"{type(mine).__name__} in place of {type(wanted).__name__}"
    if isinstance(mine, Message):
        for name in type(mine).__slots__:
            assert_same(getattr(mine, name), getattr(wanted, name), nan=nan)
    elif isinstance(mine, (list, tuple)):
        assert len(mine) == len(wanted), "length"
        for one, other in zip(mine, wanted, strict=True):
            assert_same(one, other, nan=nan)
    else:
        assert mine == wanted or (nan and math.isnan(mine)), f"{mine!r} in place of {wanted!r}"


def faults(seeds: range, cuts: int = 8) -> list[str]:
    """Check many definitions; return what does not hold, with the seeds."""
    found = []
    for seed in seeds:
        try:
            check(seed, cuts)
        except Exception as error:  # noqa: BLE001  all are faults
            found.append(f"seed {seed}: {type(error).__name__}: {str(error)[:300]}")
    return found


if __name__ == "__main__":
    first, count = map(int, sys.argv[1:])
    result = faults(range(first, first + count), cuts=100)
    print("\n".join(result))
    print(f"{count} definitions, {len(result)} faults")
