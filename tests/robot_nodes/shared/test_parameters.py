from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from typing import Any

import pytest

from pyros1.node import Node
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number

Read = Callable[[PrivateParameters], Any]


@pytest.mark.parametrize(
    ("value", "read", "expected"),
    [
        (2, lambda values: values.number("x", 1.0), 2.0),
        (0.25, lambda values: values.number("x", 1.0, 0.0, 0.25), 0.25),
        (2.6, lambda values: values.integer("x", 1), 3),
        (True, lambda values: values.flag("x", False), True),
        ("odom", lambda values: values.text("x", ""), "odom"),
        ({"y": [1]}, lambda values: values.value("x/y"), [1]),
        ({"y": 4}, lambda values: values.number("x/y", 1.0), 4.0),
        ({"y": 4}, lambda values: values.value("x/y/z"), None),
        (1, lambda values: values.number("other", 7.0), 7.0),
    ],
)
def test_values_that_can_be_used(value: object, read: Read, expected: object) -> None:
    problems: list[str] = []
    found = read(PrivateParameters({"x": value}, problems.append))
    assert (found, type(found), problems) == (expected, type(expected), [])


@pytest.mark.parametrize(
    ("value", "read", "problem"),
    [
        ("fast", lambda values: values.number("x", 1.0), "a number, not 'fast': using 1.0"),
        (True, lambda values: values.number("x", 1.0), "a number, not True: using 1.0"),
        (nan, lambda values: values.number("x", 1.0), "a number, not nan: using 1.0"),
        (-1, lambda values: values.number("x", 1.0, 0.0), "a number of at least 0, not -1: using 1.0"),
        (2, lambda values: values.number("x", 1.0, 0, 1), "a number from 0 to 1, not 2: using 1.0"),
        (2.6, lambda values: values.integer("x", 1, maximum=2), "an integer up to 2, not 2.6: using 1"),
        (inf, lambda values: values.integer("x", 1), "an integer, not inf: using 1"),
        (1, lambda values: values.flag("x", False), "true or false, not 1: using False"),
        ("a\nb", lambda values: values.flag("x", False), "true or false, not 'a\\nb': using False"),
        (["odom"], lambda values: values.text("x", "map"), "a string, not ['odom']: using 'map'"),
    ],
)
def test_values_that_cannot_be_used_are_reported(value: object, read: Read, problem: str) -> None:
    problems: list[str] = []
    read(PrivateParameters({"x": value}, problems.append, "/arm"))
    assert problems == [f"the parameter /arm/x must be {problem}"]


def test_numbers() -> None:
    assert [is_number(value) for value in (0, 1.5, -(2**62), True, nan, inf, 10**400, "1", None)] == [
        *[True] * 3,
        *[False] * 6,
    ]


def test_of_a_node(make_node: Callable[..., Node]) -> None:
    node = make_node("driver")
    assert PrivateParameters.of(node).number("rate", 5.0) == 5.0
    node.params["~rate"] = 20
    node.params["~frames/base"] = "base_link"
    values = PrivateParameters.of(node)
    assert (values.number("rate", 5.0), values.text("frames/base", "")) == (20.0, "base_link")
