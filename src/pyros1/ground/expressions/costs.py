"""Costs of operations and functions: an estimate, in advance, of the number of items that they process.

A message counts with all its fields; operations that visit only the top level of a value cost less than those that
compare, sort or format it. If an operation may visit all pairs of items, the pairs count.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pyros1.ground.expressions.functions import name_of, owner_of
from pyros1.ground.expressions.limits import CONTAINERS, HASHED, SCALARS, STEP, TEXTS, array_size, inside

_PLAIN = SCALARS - {int}
_PAIRS = 64
"""Number of pairs of characters that count as one item."""
_GLANCE = frozenset({"get", "has", "isinstance", "len"})
"""Functions that do not visit the items of their arguments."""
_SURFACE = frozenset({"all", "any", "bool", "enumerate", "filter", "list", "map", "reversed", "sum", "tuple", "zip"})
"""Functions that visit the items of a value, but not nested items."""
_BRIEF = frozenset({"endswith", "get", "items", "keys", "startswith", "values"})
"""Methods that do not visit the items of their value."""
_PRECISE = frozenset({"fsum", "gcd", "lcm", "isqrt", "dist", "sumprod", "hypot", "round", "divmod"})
"""Functions that do much work for each number, or for each 64 bits of one."""
_PRECISE_FACTOR = 20
_FIELD = 8
"""Cost of one field of a format string, in addition to the formatted value."""


def surface(value: Any) -> int:
    """Return the number of items at the top level of a value; eight characters count as one."""
    kind = type(value)
    if kind in SCALARS:
        return 0
    if kind in TEXTS:
        return len(value) >> 3
    return len(value) if isinstance(value, CONTAINERS) else array_size(value)


def depth(value: Any, limit: int) -> int:
    """Return the number of items in a value and in nested values, each as often as it occurs.

    Args:
        value: any value; eight characters count as one item (in a message each character, since they are quoted one
            by one), and so do 64 bits of a large integer.
        limit: number at which counting stops.
    """
    total = 0
    shift = 3  # of a text's length
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
                total += inside(part, pending)
                total += len(pending) - before
                if isinstance(part, dict):
                    total += len(part) + inside(part.values(), pending)
        elif kind not in SCALARS:
            shift = 0
            total += _other(part, pending)
        if total > limit:
            break
    return total


def _other(value: Any, pending: list[Any]) -> int:
    """Count a message and add its fields to `pending`, or count an object of another library."""
    if type(value).__module__ == "numpy":
        return array_size(value)
    slots = getattr(type(value), "__slots__", ())
    pending.extend(getattr(value, name, None) for name in slots)
    return STEP * (1 + len(slots))


def call(function: Callable[..., Any], arguments: Sequence[Any], keywords: Mapping[str, Any], limit: int) -> int:
    """Return the cost of a call.

    Args:
        function: the function.
        arguments: its arguments.
        keywords: its keyword arguments.
        limit: number at which counting stops.
    """
    owner, name = owner_of(function), name_of(function)
    if owner is None and name in _GLANCE:
        return 0
    if owner is None and name in _SURFACE:
        return sum(map(surface, arguments))
    if owner is None and not keywords and all(type(value) in _PLAIN for value in arguments):
        return 0
    inside = sum(depth(value, limit) for value in (*arguments, *keywords.values()))
    if owner is not None:
        return inside + _method(name, owner, arguments, inside, limit)
    if name == "sorted" and arguments:
        return inside * max(1, surface(arguments[0]).bit_length() // 4)
    return inside * (_PRECISE_FACTOR if name in _PRECISE else 1)


def _method(name: str, owner: Any, arguments: Sequence[Any], inside: int, limit: int) -> int:
    if name in _BRIEF:
        return 0
    if name == "format":  # each field may format all arguments again
        return int(owner.count("{")) * (_FIELD + inside)
    if type(owner) not in TEXTS:
        return depth(owner, limit)
    return surface(owner) + sum(sought(argument, owner) for argument in arguments)


def sought(text: Any, where: Any) -> int:
    """Return the cost of a search for a string in another, or of stripping its characters from it: the pairs count."""
    if type(text) not in TEXTS or type(where) not in TEXTS:
        return 0
    return len(text) * len(where) // _PAIRS


def contained(item: Any, where: Any, limit: int) -> int:
    """Return the cost of ``item in where``."""
    if type(where) in TEXTS:
        return surface(where) + sought(item, where)
    if isinstance(where, HASHED):
        return depth(item, limit)  # its hash
    return surface(where) if type(item) in SCALARS else depth(where, limit)


def binary(op: ast.operator, left: Any, right: Any, limit: int) -> int:
    """Return the cost of an operator with two values, in addition to its result."""
    if isinstance(op, ast.Mod) and isinstance(left, str):  # each field may format all arguments again
        return surface(left) + left.count("%") * (_FIELD + depth(right, limit))
    if type(left) is int and type(right) is int:
        return (left.bit_length() + right.bit_length()) >> 8
    return surface(left) + surface(right)
