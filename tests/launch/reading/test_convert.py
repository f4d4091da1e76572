# ruff: noqa: E501 - tables and programs in one line
"""Parameter types (X41, X74) and booleans (X55)."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.convert import convert_bool, convert_condition, convert_value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("42", 42), ("-3", -3), ("+5", 5), ("007", 7), ("1.5", 1.5), ("1.5e3", 1500.0), ("5.", 5.0), (".5", 0.5), ("1e3", "1e3"), ("0x10", "0x10"),
        ("1_000", "1_000"), ("yes", "yes"), ("nan", "nan"), ("TRUE", True), ("False", False), ("1.2.3", "1.2.3"), ("", ""), ("a b", "a b"), (" 7 ", 7),
        ("echo\n", "echo\n"),
    ],
)  # fmt: skip
def test_automatic_typing_x74(text: str, value: Any) -> None:
    converted = convert_value(text, "auto")
    assert converted == value
    assert type(converted) is type(value)


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("1", "str", "1"),
        ("1", "string", "1"),
        (" 1", "int", 1),
        ("1", "double", 1.0),
        ("1", "bool", True),
        ("no", "yaml", False),
        ("F", "str", "F"),
    ],
)
def test_named_types_x41(text: str, kind: str, value: Any) -> None:
    assert convert_value(text, kind) == value


@pytest.mark.parametrize(("text", "kind"), [("a", "int"), ("a", "double"), ("2", "bool"), ("1", "foo")])
def test_wrong_values_are_refused(text: str, kind: str) -> None:
    with pytest.raises(LaunchError):
        convert_value(text, kind)


def test_conditions_and_booleans_x55() -> None:
    assert [convert_condition(text) for text in ("1", "true", "TRUE", "0", "False")] == [True, True, True, False, False]
    assert convert_bool("True", "respawn") and not convert_bool("false", "respawn")
    with pytest.raises(LaunchError, match="maybe is not a 'bool' type"):
        convert_condition("maybe")
    with pytest.raises(LaunchError, match="respawn"):
        convert_bool("1", "respawn")
