"""Classes from received definitions (G15)."""

from __future__ import annotations

from typing import Any

import codec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.msgs import DefinitionCache, from_definition, load_message
from pyros1.msgs.dynamic import MAX_TEXT_LENGTH

SEPARATOR = "=" * 80


def test_a_definition_from_a_header_gives_the_same_md5_and_text() -> None:
    for name in ("sensor_msgs/PointCloud2", "tf2_msgs/TFMessage", "std_msgs/Empty", "rosgraph_msgs/Log"):
        known = load_message(name)
        cls = from_definition(name, known._full_text)
        assert cls is not known
        assert (cls._md5sum, cls._full_text, cls._slot_types) == (known._md5sum, known._full_text, known._slot_types)


def test_the_text_wins_over_what_is_installed() -> None:
    cls: Any = from_definition("p/T", f"std_msgs/String s\n{SEPARATOR}\nMSG: std_msgs/String\nint8 other\n")
    assert cls().s.other == 0


def test_header_needs_no_text_and_roslib_is_std_msgs() -> None:
    plain: Any = from_definition("p/T", "Header header")
    old: Any = from_definition(
        "p/T", f"roslib/Header header\n{SEPARATOR}\nMSG: roslib/Header\nuint32 seq\ntime stamp\nstring frame_id"
    )
    assert plain._md5sum == old._md5sum
    assert plain._has_header and old._has_header


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("Missing x", "uses p/Missing, but its text is missing"),
        ("wrong", "definition of p/T, p/T:1: "),
        (f"A a\n{SEPARATOR}\nMSG: p/A\nT t", "contains itself"),
        ("T t", "contains itself"),
        (f"{SEPARATOR}\nnothing", "no 'MSG: type' line"),
        (" " * (MAX_TEXT_LENGTH + 1), "characters"),
    ],
)
def test_errors(text: str, reason: str) -> None:
    with pytest.raises(DefinitionError, match=reason):
        from_definition("p/T", text)


def test_bad_type_name() -> None:
    with pytest.raises(DefinitionError, match="package/Type"):
        from_definition("*", "")


@given(
    st.lists(st.sampled_from([SEPARATOR, "MSG: p/A", "A", "int8", "x", "[]", "[3]", " ", "\n", "T", "=1"])).map("".join)
)
def test_any_text_gives_a_class_or_the_documented_error(text: str) -> None:
    try:
        cls = from_definition("p/T", text)
    except DefinitionError:
        return
    data = codec.encode(cls())
    assert codec.decode(cls, data, 0, len(data)) == cls()


def test_cache() -> None:
    cache = DefinitionCache(limit=2)
    first = cache.get("p/T", "*", "int8 a")
    assert cache.get("p/T", "*", "int8 a") is first
    assert cache.get("p/T", "*", "int8 b") is not first
    cache.get("p/T", "*", "int8 c")
    assert cache.get("p/T", "*", "int8 a") is not first  # the oldest had to go
    assert cache.get("std_msgs/Empty", "d41d8cd98f00b204e9800998ecf8427e", "")._slot_types == []
    with pytest.raises(UnknownTypeError, match="sent no definition"):
        cache.get("p/T", "992ce8a1687cec8c8bd883ec73ca41d1", "")


def test_cache_keeps_all_up_to_its_limit() -> None:
    cache = DefinitionCache(limit=5)
    classes = [cache.get("p/T", "*", f"int8 a{i}") for i in range(5)]
    assert [cache.get("p/T", "*", f"int8 a{i}") for i in range(5)] == classes
