"""Expressions that users give to ``--filter``: Python's syntax, but nothing that could harm (`pyros1.expressions`)."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pyros1.expressions import ExpressionError, Interpreter
from pyros1.msgs import Message
from pyros1.timing import TVal

__all__ = ["FUNCTIONS", "STRING_METHODS", "TIME_METHODS", "Expression", "ExpressionError"]

_MAX_DIGITS = 400


def _round(number: Any, digits: int | None = None) -> Any:
    """round(), which for an integer would calculate any power of ten."""
    if digits is not None and abs(digits) > _MAX_DIGITS:
        raise ValueError("that many digits cannot be rounded to")
    return round(number, digits)


def _sum(numbers: Iterable[Any]) -> Any:
    """sum(), of numbers only: lists would be copied again with every step."""
    return sum(numbers)


FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{f.__name__: f for f in (abs, all, any, bool, float, int, len, max, min, sorted, str)},
    **{f.__name__: f for f in (math.sqrt, math.sin, math.cos, math.atan2, math.hypot, math.isnan, math.isinf)},
    "round": _round,
    "sum": _sum,
}
"""Functions that every expression may call."""
STRING_METHODS = frozenset(
    {"startswith", "endswith", "find", "count", "lower", "upper", "strip", "lstrip", "rstrip", "split", "isdigit"}
)
"""What expressions may use of texts."""
TIME_METHODS = frozenset({"secs", "nsecs", "to_sec", "to_nsec", "is_zero"})
"""What expressions may use of times and durations."""


class Expression:
    """A checked expression.

    Args:
        text: for example ``m.data > 3 and 'x' in m.name``.

    Raises:
        ExpressionError: it is malformed or uses what is not allowed.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        try:
            self._filter = _Filter(text)
        except ExpressionError as error:
            raise ExpressionError(f"[{text}]: {error}") from None

    def __call__(self, names: Mapping[str, Any]) -> Any:
        """Return the expression's value.

        Args:
            names: what the names in it stand for.

        Raises:
            ExpressionError: a name or field does not exist, types do not fit, ...
        """
        try:
            return self._filter.evaluate(names)
        except ExpressionError as error:
            raise ExpressionError(f"[{self.text}]: {error}") from None


class _Filter(Interpreter):
    nodes = Interpreter.nodes | {ast.Attribute, ast.Call}
    max_items = 1_000_000  # the text of a message, for one, may be long

    def check(self, node: ast.AST) -> None:
        super().check(node)
        if isinstance(node, ast.Call):
            if node.keywords:
                raise ExpressionError("only plain function calls are possible")
            if isinstance(node.func, ast.Name) and node.func.id not in FUNCTIONS:
                raise ExpressionError(f"there is no function {node.func.id}; there are: {', '.join(sorted(FUNCTIONS))}")

    def name(self, name: str, names: Mapping[str, Any]) -> Any:
        if name in names:
            return names[name]
        if name == "pi":
            return math.pi
        if name in FUNCTIONS:
            return FUNCTIONS[name]
        raise ExpressionError(f"there is no name {name!r}; there are: {', '.join(sorted(names))}")

    def attribute(self, owner: Any, name: str) -> Any:
        """Fields of messages, and what is of use of times and texts."""
        if isinstance(owner, Message):
            allowed = name in owner.__slots__ or name.isupper()
        elif isinstance(owner, TVal):
            allowed = name in TIME_METHODS
        else:
            allowed = isinstance(owner, str) and name in STRING_METHODS
        return getattr(owner, name) if allowed else super().attribute(owner, name)
