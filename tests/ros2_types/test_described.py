"""Descriptions of types as rosidl installs them."""

from __future__ import annotations

import json
from typing import Any

import pytest

from pyros1.ground.errors import DefinitionError
from pyros1.ros2_types.described import read_description
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType


def description(*types: tuple[int, int, int, str]) -> dict[str, Any]:
    keys = ("type_id", "capacity", "string_capacity", "nested_type_name")
    fields = [
        {"name": f"f{number}", "type": dict(zip(keys, each, strict=True)), "default_value": ""}
        for number, each in enumerate(types)
    ]
    return {
        "type_description_msg": {
            "type_description": {"type_name": "a/msg/A", "fields": fields},
            "referenced_type_descriptions": [{"type_name": "a/msg/B", "fields": []}],
        }
    }


@pytest.mark.parametrize(
    ("described", "expected"),
    [
        ((6, 0, 0, ""), FieldType("int32")),
        ((21, 0, 5, ""), FieldType("string", string_bound=5)),
        ((22 + 144, 0, 7, ""), FieldType("wstring", Length.UNBOUNDED, 0, 7)),
        ((11 + 48, 36, 0, ""), FieldType("float64", Length.FIXED, 36)),
        ((16 + 96, 8, 0, ""), FieldType("byte", Length.BOUNDED, 8)),
        ((1, 0, 0, "a/msg/B"), FieldType("a/msg/B")),
        ((1 + 144, 0, 0, "a/msg/B"), FieldType("a/msg/B", Length.UNBOUNDED)),
    ],
)
def test_fields(described: tuple[int, int, int, str], expected: FieldType) -> None:
    types = read_description(json.dumps(description(described)))
    assert types == {"a/msg/A": MessageType("a/msg/A", (Field("f0", expected),)), "a/msg/B": MessageType("a/msg/B", ())}


def test_the_field_of_empty_types_is_left_out() -> None:
    empty = description((3, 0, 0, ""))
    empty["type_description_msg"]["type_description"]["fields"][0]["name"] = "structure_needs_at_least_one_member"
    assert read_description(json.dumps(empty))["a/msg/A"].fields == ()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"type_description_msg": 1}',
        "[" * 100_000,
        json.dumps(description((12, 0, 0, ""))),
        json.dumps(description((13, 0, 0, ""))),
        json.dumps(description((1, 0, 0, ""))),
        json.dumps(description((193, 0, 0, "a/msg/B"))),
        json.dumps(description((0, 0, 0, ""))),
        json.dumps(description((-47, 0, 0, "a/msg/B"))),
        json.dumps(description((6 + 48, 0, 0, ""))),
        json.dumps(description((6 + 48, -1, 0, ""))),
        json.dumps(description((6 + 96, 1 << 32, 0, ""))),
        json.dumps(description((6, 0, 1, ""))),
        json.dumps(description((21, 0, 0, ""))),
        json.dumps(description((21, 0, 10**400, ""))),
        json.dumps(description((6 + 48, 3, 0, ""))).replace("3", "Infinity"),
        json.dumps(description(*[(6, 0, 0, "")] * 10_001)),
    ],
)
def test_what_is_refused(text: str) -> None:
    with pytest.raises(DefinitionError):
        read_description(text)
