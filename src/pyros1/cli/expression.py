"""Expressions that users give to ``--filter``: Python's syntax, but nothing that could harm.

An expression is parsed into Python's syntax tree, checked to consist of harmless parts, and walked for each message.
There is no way to names that begin with ``_``, to imports, or to functions other than those named here.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from pyros1.errors import Error
from pyros1.msgs import Message
from pyros1.timing import TVal

MAX_LENGTH = 10_000
"""Most characters of an expression."""

_MAX_BITS = 4096
_MAX_ITEMS = 1_000_000


class ExpressionError(Error):
    """An expression is malformed, uses what is not allowed, or fails on a message."""


_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.Not: operator.not_,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{f.__name__: f for f in (abs, all, any, bool, float, int, len, max, min, round, sorted, str, sum)},
    **{f.__name__: f for f in (math.sqrt, math.sin, math.cos, math.atan2, math.hypot, math.isnan, math.isinf)},
}
_CONSTANTS = {"pi": math.pi, "None": None, "True": True, "False": False}
_STRING_METHODS = frozenset(
    {"startswith", "endswith", "find", "count", "lower", "upper", "strip", "lstrip", "rstrip", "split", "isdigit"}
)
_TIME_METHODS = frozenset({"to_sec", "to_nsec", "is_zero"})


class Expression:
    """A checked expression.

    Args:
        text: for example ``m.data > 3 and 'x' in m.name``.

    Raises:
        ExpressionError: it is malformed or uses what is not allowed.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        if len(text) > MAX_LENGTH:
            raise ExpressionError(f"the expression has more than {MAX_LENGTH} characters")
        try:
            self._root = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise ExpressionError(f"[{text}] is not an expression: {getattr(error, 'msg', error)}") from None
        try:
            for node in ast.walk(self._root):
                _check(node, text)
        except RecursionError:
            raise ExpressionError(f"[{text}] is nested too deeply") from None

    def __call__(self, names: Mapping[str, Any]) -> Any:
        """Return the expression's value.

        Args:
            names: what the names in it stand for.

        Raises:
            ExpressionError: a name or field does not exist, types do not fit, ...
        """
        try:
            return _value(self._root, names)
        except ExpressionError:
            raise
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, RecursionError) as error:
            raise ExpressionError(f"[{self.text}]: {error}") from None


_ALLOWED = (
    ast.BinOp, ast.BoolOp, ast.Compare, ast.Constant, ast.IfExp, ast.List, ast.Name, ast.Slice, ast.Subscript,
    ast.Tuple, ast.UnaryOp, ast.boolop, ast.cmpop, ast.expr_context, ast.operator, ast.unaryop,
)  # fmt: skip


def _check(node: ast.AST, text: str) -> None:
    if isinstance(node, ast.Attribute):
        if node.attr.startswith("_"):
            raise ExpressionError(f"[{text}]: {node.attr} is not accessible")
    elif isinstance(node, ast.Call):
        if node.keywords or not isinstance(node.func, (ast.Name, ast.Attribute)):
            raise ExpressionError(f"[{text}]: only plain function calls are possible")
        if isinstance(node.func, ast.Name) and node.func.id not in _FUNCTIONS:
            raise ExpressionError(
                f"[{text}]: there is no function {node.func.id}; there are: {', '.join(sorted(_FUNCTIONS))}"
            )
    elif not isinstance(node, _ALLOWED) or isinstance(node, ast.MatMult):
        raise ExpressionError(f"[{text}]: {type(node).__name__} is not possible in an expression")


def _value(node: ast.AST, names: Mapping[str, Any]) -> Any:  # noqa: PLR0911, PLR0912 - one branch per kind of node
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name):
        if node.id in names:
            return names[node.id]
        if node.id in _CONSTANTS:
            return _CONSTANTS[node.id]
        raise ExpressionError(f"there is no name {node.id!r}; there are: {', '.join(sorted(names))}")
    if isinstance(node, ast.Attribute):
        return _attribute(_value(node.value, names), node.attr)
    if isinstance(node, ast.Subscript):
        return _value(node.value, names)[_value(node.slice, names)]
    if isinstance(node, ast.Slice):
        return slice(*(None if part is None else _value(part, names) for part in (node.lower, node.upper, node.step)))
    if isinstance(node, ast.BoolOp):
        result = None
        for operand in node.values:
            result = _value(operand, names)
            if bool(result) is isinstance(node.op, ast.Or):
                break
        return result
    if isinstance(node, ast.UnaryOp):
        return _UNARY[type(node.op)](_value(node.operand, names))
    if isinstance(node, ast.BinOp):
        return _binary(node.op, _value(node.left, names), _value(node.right, names))
    if isinstance(node, ast.Compare):
        left = _value(node.left, names)
        for op, comparator in zip(node.ops, node.comparators, strict=True):
            right = _value(comparator, names)
            if not _COMPARE[type(op)](left, right):
                return False
            left = right
        return True
    if isinstance(node, ast.IfExp):
        return _value(node.body if _value(node.test, names) else node.orelse, names)
    if isinstance(node, (ast.List, ast.Tuple)):
        return [_value(element, names) for element in node.elts]
    assert isinstance(node, ast.Call)  # _check lets no other node pass
    return _call(node, names)


def _attribute(owner: Any, name: str) -> Any:
    """A field of a message or of a time; nothing else has attributes that are of use."""
    if isinstance(owner, Message):
        if name in owner.__slots__ or name.isupper():
            return getattr(owner, name)
    elif isinstance(owner, TVal) and name in ("secs", "nsecs"):
        return getattr(owner, name)
    raise ExpressionError(f"{type(owner).__name__!r} object has no attribute {name!r}")


def _binary(op: ast.operator, left: Any, right: Any) -> Any:
    """An operation, unless its result would be enormous."""
    if isinstance(op, (ast.Pow, ast.LShift)) and isinstance(left, int) and isinstance(right, int):
        bits = left.bit_length() * abs(right) if isinstance(op, ast.Pow) else left.bit_length() + abs(right)
        if bits > _MAX_BITS:
            raise ExpressionError("the number gets too large")
    if isinstance(op, ast.Mult):
        for sequence, count in ((left, right), (right, left)):
            if isinstance(sequence, (str, bytes, list, tuple)) and isinstance(count, int):
                if len(sequence) * count > _MAX_ITEMS:
                    raise ExpressionError("the text or list gets too long")
            elif isinstance(sequence, int) and sequence.bit_length() > _MAX_BITS:
                raise ExpressionError("the number gets too large")
    if isinstance(op, ast.Mod) and isinstance(left, (str, bytes)):
        raise ExpressionError("texts cannot be formatted")
    return _BINARY[type(op)](left, right)


def _call(node: ast.Call, names: Mapping[str, Any]) -> Any:
    arguments = [_value(argument, names) for argument in node.args]
    if isinstance(node.func, ast.Name):
        return _FUNCTIONS[node.func.id](*arguments)
    assert isinstance(node.func, ast.Attribute)  # see _check
    owner = _value(node.func.value, names)
    method = node.func.attr
    if (isinstance(owner, str) and method in _STRING_METHODS) or (isinstance(owner, TVal) and method in _TIME_METHODS):
        return getattr(owner, method)(*arguments)
    raise ExpressionError(f"{type(owner).__name__!r} object has no method {method!r}")
