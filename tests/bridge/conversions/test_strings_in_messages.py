"""Strings are changed in encoded messages as if the whole message were decoded, changed and encoded again."""

from __future__ import annotations

import random
import struct
from collections.abc import Collection
from typing import Any

import pytest
from tests.bodies import decode, encode
from tests.msgs.random_definitions import random_definition, random_message

from pyros1.bridge.conversions.strings_in_messages import MAX_STEPS, StringChanger
from pyros1.ground.errors import MessageError
from pyros1.msgs import from_definition, load_message
from pyros1.msgs.base import nested_classes


def longer(value: bytes) -> bytes:
    return b"red/" + value


def expected(message: Any, names: Collection[str]) -> Any:
    """Return the message, with its strings changed one by one."""
    nested = nested_classes(type(message))
    for name, slot_type in zip(message.__slots__, message._slot_types, strict=True):
        base, value = slot_type.partition("[")[0], getattr(message, name)
        if base in nested:
            for each in value if "[" in slot_type else [value]:
                expected(each, names)
        elif base == "string" and name in names:
            is_list = "[" in slot_type
            setattr(message, name, [f"red/{each}" for each in value] if is_list else f"red/{value}")
    return message


def string_fields(cls: Any) -> set[str]:
    found = {name for name, kind in zip(cls.__slots__, cls._slot_types, strict=True) if kind.startswith("string")}
    return found.union(*map(string_fields, nested_classes(cls).values()))


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 400, 100))
def test_random_types(first: int) -> None:
    changed = 0
    for seed in range(first, first + 100):
        rng = random.Random(seed)
        definition = random_definition(rng)
        cls: Any = from_definition(definition.name, definition.full_text())
        names = {name for name in string_fields(cls) if rng.random() < 0.8}
        changer = StringChanger(cls, dict.fromkeys(names, longer))
        body = encode(random_message(rng, cls))
        assert changer.is_useful == bool(names)
        new = changer.change(body)
        assert new == encode(expected(decode(cls, body), names)), seed
        changed += new != body
    assert changed > 15


@pytest.mark.parametrize("type_name", ["tf2_msgs/TFMessage", "visualization_msgs/MarkerArray"])
def test_messages_that_are_cut(type_name: str) -> None:
    cls: Any = load_message(type_name)
    changer = StringChanger(cls, {"frame_id": longer})
    body = encode(cls([nested_classes(cls)[cls._slot_types[0][:-2]]() for _ in range(2)]))
    for length in range(len(body)):
        with pytest.raises(MessageError, match="ends too early"):
            changer.change(body[:length])
    assert changer.change(body).count(b"red/") == 2


def test_what_follows_is_not_looked_at() -> None:
    changer = StringChanger(load_message("sensor_msgs/Image"), {"frame_id": longer})
    head = bytes(12) + b"\x03\0\0\0cam"
    assert changer.change(head + b"rest") == bytes(12) + b"\x07\0\0\0red/camrest"


def test_lengths_that_are_lies() -> None:
    changer = StringChanger(load_message("tf2_msgs/TFMessage"), {"frame_id": longer})
    for body in (b"\xff\xff\xff\xff", b"\1\0\0\0" + bytes(12) + b"\xff\xff\xff\xffx"):
        with pytest.raises(MessageError):
            changer.change(body)
    fixed = StringChanger(from_definition("a/B", "uint64[] much\nstring name\n"), {"name": longer})
    with pytest.raises(MessageError):
        fixed.change(b"\xff\xff\xff\xff" + bytes(100))


@pytest.mark.slow
def test_a_message_with_many_strings_is_refused() -> None:
    changer = StringChanger(from_definition("a/B", "string[] words\nstring name\n"), {"name": longer})

    def body(count: int) -> bytes:
        return struct.pack("<I", count) + bytes(4 * count) + b"\1\0\0\0x"

    assert changer.change(body(MAX_STEPS // 2)).endswith(b"\5\0\0\0red/x")
    with pytest.raises(MessageError, match="too many strings"):
        changer.change(body(MAX_STEPS))
    inner = "=" * 80 + "\nMSG: a/C\nuint8[] bytes\n"
    without_strings = StringChanger(from_definition("a/B", "C[] parts\nstring name\n" + inner), {"name": longer})
    with pytest.raises(MessageError, match="too many strings"):
        without_strings.change(body(MAX_STEPS))


def test_a_type_that_grows_exponentially_is_refused() -> None:
    parts = [f"MSG: a/T{n}\n" + "".join(f"T{n + 1} f{i}\n" for i in range(9)) for n in range(1, 6)]
    text = ("\n" + "=" * 80 + "\n").join(["T1 a\nT1 b", *parts, "MSG: a/T6\nstring name\nstring[] names"])
    with pytest.raises(MessageError, match="too many fields"):
        StringChanger(from_definition("a/B", text), {"name": longer})
