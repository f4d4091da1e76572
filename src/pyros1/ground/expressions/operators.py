"""The operators that expressions can use, and checks of the sizes of their results."""

from __future__ import annotations

import ast
import contextlib
import operator
import re
from collections.abc import Callable
from typing import Any

from pyros1.ground.expressions.limits import MAX_BITS, ExpressionError, check_limit, size

# A width or precision that is taken from the arguments, as in "%*d" and "%.*f".
_STAR_WIDTH_PATTERN = re.compile(r"[%)][#0 +-]*\*|\.\*")


def _invert(value: Any) -> Any:
    return ~int(value) if isinstance(value, bool) else ~value  # Python will remove ``~`` for booleans


BINARY_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.MatMult: operator.matmul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
UNARY_OPERATORS: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
    ast.Invert: _invert,
}
COMPARISON_OPERATORS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
}


def check_result(op: ast.operator, left: Any, right: Any, limit: int) -> None:
    """Check in advance how large the result of an operation would be, if small operands can give a large result.

    Args:
        op: the operator.
        left: the first operand.
        right: the second operand.
        limit: maximum `size` of the result.

    Raises:
        ExpressionError: the result would be larger.
    """
    if isinstance(op, ast.Pow | ast.LShift):
        _check_result_bits(op, left, right)
    elif isinstance(op, ast.Mult):
        _check_repetition(left, right, limit)
        _check_repetition(right, left, limit)
    elif isinstance(op, ast.Mod) and isinstance(left, str | bytes | bytearray):
        _check_format_widths(left, limit)


def _check_result_bits(op: ast.operator, left: Any, right: Any) -> None:
    if isinstance(left, int) and isinstance(right, int) and right > 0:
        bits = left.bit_length()
        # For a power, this is the minimum number of bits; the power never has more than twice as many.
        check_limit(bits + right if isinstance(op, ast.LShift) else (bits - 1) * right, MAX_BITS)


def _check_repetition(sequence: Any, count: Any, limit: int) -> None:
    if isinstance(sequence, str | bytes | bytearray | list | tuple) and not isinstance(count, float):
        with contextlib.suppress(TypeError):  # works with numpy integers as well
            check_limit(size(sequence, limit) * operator.index(count), limit)


def _check_format_widths(template: str | bytes | bytearray, limit: int) -> None:
    if not isinstance(template, str):
        raise ExpressionError("only strings can be formatted with %")
    if _STAR_WIDTH_PATTERN.search(template):
        raise ExpressionError("strings cannot be formatted with a width of *")
    # Each number in the string is counted as if it were a width or precision.
    numbers = (number.lstrip("0")[:9] for number in re.findall(r"[0-9]+", template))
    check_limit(sum(int(number or "0") for number in numbers), limit)
