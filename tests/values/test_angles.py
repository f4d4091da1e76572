"""values.angles: the arithmetic of ``rad(...)`` and ``!radians``."""

from __future__ import annotations

import math

import pytest

from pyros1.ground.expressions import ExpressionError
from pyros1.values.angles import evaluate_angle


@pytest.mark.parametrize(
    ("text", "value"),
    [("1", 1.0), ("-pi/2", -math.pi / 2), ("(1 + 2) * 3 - 1", 8.0), ("7 // 2", 3.0), ("2**3 % 5", 3.0), ("+0.5", 0.5)],
)
def test_arithmetic(text: str, value: float) -> None:
    found = evaluate_angle(text)
    assert found == value and type(found) is float


@pytest.mark.parametrize("text", ["True", "1 + True", "1j", "'1'", "None", "...", "(-1)**0.5"])
def test_other_values_are_refused(text: str) -> None:
    with pytest.raises(ExpressionError, match="only numbers, pi and arithmetic are allowed"):
        evaluate_angle(text)


@pytest.mark.parametrize("text", ["", "e", "pi()", "1 < 2", "not 1", "[1]", "1/0", "1 if 1 else 2"])
def test_other_expressions_are_refused(text: str) -> None:
    with pytest.raises(ExpressionError):
        evaluate_angle(text)
