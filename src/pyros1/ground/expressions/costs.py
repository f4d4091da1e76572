"""Estimates the cost of an operation or function before it is executed: the number of items that it will process.

All fields of a message count. An operation that only visits the top level of a value costs less than one that compares,
sorts or formats the value. If an operation may compare all pairs of items, each pair counts.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pyros1.ground.expressions.functions import function_name, method_owner
from pyros1.ground.expressions.limits import (
    CONTAINER_TYPES,
    HASHED_TYPES,
    SCALAR_TYPES,
    STEP_COST,
    TEXT_TYPES,
    array_size,
    nested_size,
)

_FIXED_COST_TYPES = SCALAR_TYPES - {int}
_PAIRS_PER_ITEM = 64
"""Number of pairs of characters that count as one item."""
_CONSTANT_TIME_FUNCTIONS = frozenset({"get", "has", "isinstance", "len"})
"""Functions that do not visit the items of their arguments."""
_LINEAR_TIME_FUNCTIONS = frozenset(
    {"all", "any", "bool", "enumerate", "filter", "list", "map", "reversed", "sum", "tuple", "zip"}
)
"""Functions that visit the items of a value, but not nested items."""
_CHEAP_METHODS = frozenset({"endswith", "get", "items", "keys", "startswith", "values"})
"""Methods that do not visit the items of their value."""
_SLOW_FUNCTIONS = frozenset({"fsum", "gcd", "lcm", "isqrt", "dist", "sumprod", "hypot", "round", "divmod"})
"""Functions that do much work for each number, or for each 64 bits of a large number."""
_SLOW_FACTOR = 20
_FIELD_COST = 8
"""Cost of one field of a format string, in addition to the formatted value."""


def shallow_size(value: Any) -> int:
    """Return the number of items at the top level of a value; eight characters count as one."""
    value_type = type(value)
    if value_type in SCALAR_TYPES:
        return 0
    if value_type in TEXT_TYPES:
        return len(value) >> 3
    return len(value) if isinstance(value, CONTAINER_TYPES) else array_size(value)


def deep_size(value: Any, limit: int) -> int:
    """Return the number of items in a value and in nested values, counted as often as they occur.

    Args:
        value: any value; eight characters count as one item (in a message, each character counts, since strings are
            quoted character by character), and so do 64 bits of a large integer.
        limit: number at which counting stops.
    """
    total = 0
    shift_of_length = 3  # divides the lengths of strings by eight
    pending = [value]
    while pending:
        part = pending.pop()
        part_type = type(part)
        if part_type is int:
            total += part.bit_length() >> 6
        elif part_type in TEXT_TYPES:
            total += len(part) >> (shift_of_length if part_type is str else 3)
        elif isinstance(part, CONTAINER_TYPES):
            total += STEP_COST + len(part)
            if total <= limit:
                previous_count = len(pending)
                total += nested_size(part, pending)
                total += len(pending) - previous_count
                if isinstance(part, dict):
                    total += len(part) + nested_size(part.values(), pending)
        elif part_type not in SCALAR_TYPES:
            shift_of_length = 0
            total += _object_cost(part, pending)
        if total > limit:
            break
    return total


def _object_cost(value: Any, pending: list[Any]) -> int:
    """Return the cost of a message, whose fields are added to `pending`, or of an object from another library."""
    if type(value).__module__ == "numpy":
        return array_size(value)
    slots = getattr(type(value), "__slots__", ())
    pending.extend(getattr(value, name, None) for name in slots)
    return STEP_COST * (1 + len(slots))


def call_cost(function: Callable[..., Any], arguments: Sequence[Any], keywords: Mapping[str, Any], limit: int) -> int:
    """Return the cost of a call.

    Args:
        function: the function that is called.
        arguments: the positional arguments.
        keywords: the keyword arguments.
        limit: number at which counting stops.
    """
    owner, name = method_owner(function), function_name(function)
    if owner is None and name in _CONSTANT_TIME_FUNCTIONS:
        return 0
    if owner is None and name in _LINEAR_TIME_FUNCTIONS:
        return sum(map(shallow_size, arguments))
    if owner is None and not keywords and all(type(value) in _FIXED_COST_TYPES for value in arguments):
        return 0
    arguments_size = sum(deep_size(value, limit) for value in (*arguments, *keywords.values()))
    if owner is not None:
        return arguments_size + _method_cost(name, owner, arguments, arguments_size, limit)
    if name == "sorted" and arguments:
        return arguments_size * max(1, shallow_size(arguments[0]).bit_length() // 4)
    return arguments_size * (_SLOW_FACTOR if name in _SLOW_FUNCTIONS else 1)


def _method_cost(name: str, owner: Any, arguments: Sequence[Any], arguments_size: int, limit: int) -> int:
    if name in _CHEAP_METHODS:
        return 0
    if name == "format":  # each field may format all arguments again
        return int(owner.count("{")) * (_FIELD_COST + arguments_size)
    if type(owner) not in TEXT_TYPES:
        return deep_size(owner, limit)
    return shallow_size(owner) + sum(search_cost(argument, owner) for argument in arguments)


def search_cost(text: Any, searched: Any) -> int:
    """Return the cost of searching for a string in another one, or of stripping characters: each pair of characters
    counts.
    """
    if type(text) not in TEXT_TYPES or type(searched) not in TEXT_TYPES:
        return 0
    return len(text) * len(searched) // _PAIRS_PER_ITEM


def membership_cost(item: Any, container: Any, limit: int) -> int:
    """Return the cost of ``item in container``."""
    if type(container) in TEXT_TYPES:
        return shallow_size(container) + search_cost(item, container)
    if isinstance(container, HASHED_TYPES):
        return deep_size(item, limit)  # only the item's hash is computed
    return shallow_size(container) if type(item) in SCALAR_TYPES else deep_size(container, limit)


def operator_cost(op: ast.operator, left: Any, right: Any, limit: int) -> int:
    """Return the cost of a binary operation, in addition to the cost of its result."""
    if isinstance(op, ast.Mod) and isinstance(left, str):  # each field may format all arguments again
        return shallow_size(left) + left.count("%") * (_FIELD_COST + deep_size(right, limit))
    if type(left) is int and type(right) is int:
        return (left.bit_length() + right.bit_length()) >> 8
    return shallow_size(left) + shallow_size(right)
