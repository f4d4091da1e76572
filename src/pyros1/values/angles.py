"""The arithmetic of ``rad(...)`` and ``!radians`` (https://wiki.ros.org/rosparam#YAML_Format).

Stock has Python evaluate the text. Values come from others, so here it is the safe language of `pyros1.expressions`,
without everything but numbers.
"""

from __future__ import annotations

import ast
import math
from typing import Any

from pyros1.expressions import ExpressionError, Interpreter


def radians(text: str) -> float:
    """Return the value of numbers and ``pi`` under arithmetic's operators and parentheses, all as floating point.

    Args:
        text: for example ``-pi/2``.

    Returns:
        The value.

    Raises:
        ExpressionError: anything else is in the text, or it has no value.
    """
    return float(_Arithmetic(text).evaluate({"pi": math.pi}))


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
