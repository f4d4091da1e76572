from __future__ import annotations

from typing import Any

import pytest

from pyros1.robot_nodes.rosserial_python.parameters import UnsuitableParameterError, parameter_response


@pytest.mark.parametrize(
    ("value", "field", "found"),
    [
        (7, "ints", [7]),
        (True, "ints", [1]),
        ([1, 2], "ints", [1, 2]),
        (0.5, "floats", [0.5]),
        ([0.5, 1.5], "floats", [0.5, 1.5]),
        ("left", "strings", ["left"]),
        (["a", "b"], "strings", ["a", "b"]),
        ([], "ints", []),
    ],
)
def test_values_go_into_the_array_of_their_type(value: Any, field: str, found: list[Any]) -> None:
    response = parameter_response("p", value)
    others = {"ints", "floats", "strings"} - {field}
    assert list(getattr(response, field)) == found and not any(getattr(response, name) for name in others)


@pytest.mark.parametrize("value", [None, {"a": 1}, [1, "a"], [1, 2.5], [[1]], 2**40, [None]])
def test_other_values_cannot_be_sent(value: Any) -> None:
    with pytest.raises(UnsuitableParameterError, match="the board asks for the parameter /gains, which"):
        parameter_response("/gains", value)
