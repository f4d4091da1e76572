"""Evaluates the arithmetic in ``rad(...)`` and ``!radians`` (https://wiki.ros.org/rosparam#YAML_Format).

Stock evaluates the text as Python. Since values may come from untrusted sources, it is evaluated here with the safe
language of `pyros1.ground.expressions`, limited to numbers.
"""

from __future__ import annotations

import ast
import math
from typing import Any

from pyros1.ground.expressions import ExpressionError, Interpreter


def evaluate_angle(text: str) -> float:
    """Evaluate an arithmetic expression with numbers, ``pi`` and parentheses, in floating point.

    Args:
        text: the expression, for example ``-pi/2``.

    Returns:
        The value of the expression.

    Raises:
        ExpressionError: the text contains anything else, or cannot be evaluated.
    """
    return float(_Arithmetic(text).evaluate({"pi": math.pi}))


class _Arithmetic(Interpreter):
    allowed_nodes = frozenset((ast.BinOp, ast.Constant, ast.Name, ast.UnaryOp))

    def constant(self, value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ExpressionError("only numbers, pi and arithmetic are allowed")
        return float(value)

    def evaluate_node(self, node: ast.expr, names: Any) -> Any:
        result = super().evaluate_node(node, names)
        if not isinstance(result, float):
            raise ExpressionError("only numbers, pi and arithmetic are allowed")
        return result
