"""Angles in YAML: ``deg(90)``, ``!degrees 90``, ``rad(pi/2)``, ``!radians pi/2``.

https://wiki.ros.org/rosparam#YAML_Format
"""

from __future__ import annotations

import ast
import math
from typing import Any

from pyros1.expressions import ExpressionError, Interpreter


def degrees(text: str) -> float:
    """Return the radians of an angle in degrees, a plain number.

    Raises:
        ValueError: it is no number.
    """
    return float(_inside(text, "deg(")) * math.pi / 180.0  # not math.radians, which differs from stock's last digit


def _inside(text: str, begin: str) -> str:
    return text[len(begin) : -1] if text.startswith(begin) and text.endswith(")") else text


def radians(text: str) -> float:
    """Return the value of numbers and ``pi`` under arithmetic's operators and parentheses, all as floating point.

    Args:
        text: for example ``-pi/2`` or ``rad(-pi/2)``.

    Returns:
        The value.

    Raises:
        ExpressionError: anything else is in the text, or it has no value.
    """
    return float(_Arithmetic(_inside(text, "rad(")).evaluate({"pi": math.pi}))


class _Arithmetic(Interpreter):
    nodes = frozenset((ast.BinOp, ast.Constant, ast.Name, ast.UnaryOp))

    def constant(self, value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ExpressionError("only numbers, pi and arithmetic are possible")
        return float(value)

    def value(self, node: ast.expr, names: Any) -> Any:
        result = super().value(node, names)
        if not isinstance(result, float):
            raise ExpressionError("only numbers, pi and arithmetic are possible")
        return result
