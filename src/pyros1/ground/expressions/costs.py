"""Estimates the costs of operations and functions in advance: the number of items that they process.

A message counts with all its fields; operations that visit only the top level of a value cost less than those that
compare, sort or format it. If an operation may visit all pairs of items, each pair counts.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pyros1.ground.expressions.functions import function_name, method_owner
from pyros1.ground.expressions.limits import CONTAINERS, HASHED, SCALARS, STEP, TEXTS, array_size, nested_size

_FIXED_COST = SCALARS - {int}
_PAIRS_PER_STEP = 64
"""Number of pairs of characters that count as one item."""
_CONSTANT_TIME = frozenset({"get", "has", "isinstance", "len"})
"""Functions that do not visit the items of their arguments."""
_LINEAR_TIME = frozenset(
    {"all", "any", "bool", "enumerate", "filter", "list", "map", "reversed", "sum", "tuple", "zip"}
)
"""Functions that visit the items of a value, but not nested items."""
_CHEAP_METHODS = frozenset({"endswith", "get", "items", "keys", "startswith", "values"})
"""Methods that do not visit the items of their value."""
_SLOW_FUNCTIONS = frozenset({"fsum", "gcd", "lcm", "isqrt", "dist", "sumprod", "hypot", "round", "divmod"})
"""Functions that do much work for each number, or for each 64 bits of a number."""
_SLOW_FACTOR = 20
_FIELD_COST = 8
"""Cost of one field of a format string, in addition to the formatted value."""


def shallow_size(value: Any) -> int:
    """Return the number of items at the top level of a value; eight characters count as one."""
    kind = type(value)
    if kind in SCALARS:
        return 0
    if kind in TEXTS:
        return len(value) >> 3
    return len(value) if isinstance(value, CONTAINERS) else array_size(value)


def deep_size(value: Any, limit: int) -> int:
    """Return the number of items in a value and in nested values, counted as often as they occur.

    Args:
        value: any value; eight characters count as one item (in a message, each character counts, since strings are
            quoted character by character), and so do 64 bits of a large integer.
        limit: number at which counting stops.
    """
    total = 0
    shift = 3  # for the lengths of strings
    pending = [value]
    while pending:
        part = pending.pop()
        kind = type(part)
        if kind is int:
            total += part.bit_length() >> 6
        elif kind in TEXTS:
            total += len(part) >> (shift if kind is str else 3)
        elif isinstance(part, CONTAINERS):
            total += STEP + len(part)
            if total <= limit:
                before = len(pending)
                total += nested_size(part, pending)
                total += len(pending) - before
                if isinstance(part, dict):
                    total += len(part) + nested_size(part.values(), pending)
        elif kind not in SCALARS:
            shift = 0
            total += _count_fields(part, pending)
        if total > limit:
            break
    return total


def _count_fields(value: Any, pending: list[Any]) -> int:
    """Count a message and add its fields to `pending`, or count an object of another library."""
    if type(value).__module__ == "numpy":
        return array_size(value)
    slots = getattr(type(value), "__slots__", ())
    pending.extend(getattr(value, name, None) for name in slots)
    return STEP * (1 + len(slots))


def call_cost(function: Callable[..., Any], arguments: Sequence[Any], keywords: Mapping[str, Any], limit: int) -> int:
    """Return the cost of a call.

    Args:
        function: the function.
        arguments: its arguments.
        keywords: its keyword arguments.
        limit: number at which counting stops.
    """
    owner, name = method_owner(function), function_name(function)
    if owner is None and name in _CONSTANT_TIME:
        return 0
    if owner is None and name in _LINEAR_TIME:
        return sum(map(shallow_size, arguments))
    if owner is None and not keywords and all(type(value) in _FIXED_COST for value in arguments):
        return 0
    nested_size = sum(deep_size(value, limit) for value in (*arguments, *keywords.values()))
    if owner is not None:
        return nested_size + _method_cost(name, owner, arguments, nested_size, limit)
    if name == "sorted" and arguments:
        return nested_size * max(1, shallow_size(arguments[0]).bit_length() // 4)
    return nested_size * (_SLOW_FACTOR if name in _SLOW_FUNCTIONS else 1)


def _method_cost(name: str, owner: Any, arguments: Sequence[Any], nested_size: int, limit: int) -> int:
    if name in _CHEAP_METHODS:
        return 0
    if name == "format":  # each field may format all arguments again
        return int(owner.count("{")) * (_FIELD_COST + nested_size)
    if type(owner) not in TEXTS:
        return deep_size(owner, limit)
    return shallow_size(owner) + sum(search_cost(argument, owner) for argument in arguments)


def search_cost(text: Any, where: Any) -> int:
    """Return the cost of searching for a string in another, or of stripping its characters from it: all pairs count."""
    if type(text) not in TEXTS or type(where) not in TEXTS:
        return 0
    return len(text) * len(where) // _PAIRS_PER_STEP


def membership_cost(item: Any, where: Any, limit: int) -> int:
    """Return the cost of ``item in where``."""
    if type(where) in TEXTS:
        return shallow_size(where) + search_cost(item, where)
    if isinstance(where, HASHED):
        return deep_size(item, limit)  # only its hash is computed
    return shallow_size(where) if type(item) in SCALARS else deep_size(where, limit)


def operator_cost(op: ast.operator, left: Any, right: Any, limit: int) -> int:
    """Return the cost of a binary operator, in addition to that of its result."""
    if isinstance(op, ast.Mod) and isinstance(left, str):  # each field may format all arguments again
        return shallow_size(left) + left.count("%") * (_FIELD_COST + deep_size(right, limit))
    if type(left) is int and type(right) is int:
        return (left.bit_length() + right.bit_length()) >> 8
    return shallow_size(left) + shallow_size(right)
