"""Limits on the values and the work of expressions, and the errors of expressions."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from pyros1.ground.errors import Error

MAX_TEXT = 10_000
"""Maximum number of characters of an expression."""

MAX_ITEMS = 10_000
"""Maximum number of characters or items of a computed value, including those of nested values."""

MAX_BITS = 4096
"""Maximum number of bits of a computed integer."""

MAX_WORK = 10_000_000
"""Maximum work of an expression. An operation or function costs 1 for each item that it visits, or for each eight
characters of a string; in addition, each evaluation of a node of the syntax tree costs `STEP_COST`.
"""

STEP_COST = 6
"""Cost of evaluating a node of the syntax tree or an item of a comprehension, or of accessing an item of a list."""

CALL_COST = 30
"""Cost of a call, in addition to the cost of the function."""

TOO_EXPENSIVE = "the expression takes too much work; use fewer fields or items"
TOO_LARGE = "the result is too large; use fewer fields, items or characters"
MAX_SAME_HASH = 100
"""Maximum number of keys of a set or dictionary with the same hash, such as the multiples of 2**61 - 1."""

_FIXED_SIZE = frozenset({bool, float, type(None)})
SCALAR_TYPES = _FIXED_SIZE | {int}
_MAX_SMALL_INT = 1 << 63
TEXT_TYPES = (str, bytes, bytearray)
_VIEWS: tuple[type[Any], ...] = (type({}.keys()), type({}.values()), type({}.items()))
CONTAINER_TYPES: tuple[type[Any], ...] = (list, tuple, dict, set, frozenset, *_VIEWS)
HASHED_TYPES: tuple[type[Any], ...] = (dict, set, frozenset, type({}.keys()), type({}.items()))


class ExpressionError(Error, ValueError):
    """An expression is malformed, not allowed or too large, or its evaluation fails; the message says what is wrong."""


class LimitError(ExpressionError):
    """A value in an expression would become too large, or evaluating the expression would take too much work."""


class UnknownNameError(ExpressionError):
    """An expression uses an unknown name."""


def size(value: Any, limit: int = MAX_ITEMS) -> int:
    """Return the number of characters and items in a value and in nested values, counted as often as they occur.

    Args:
        value: any value. Integers and arrays count 1 for each 64 bits; other values that are neither strings nor
            containers count 0.
        limit: number at which counting stops.

    Returns:
        The size, or any number above `limit`.
    """
    return measure(value, limit)[0]


def measure(value: Any, limit: int = MAX_ITEMS) -> tuple[int, int]:
    """Return the `size` of a value, and the work for creating the value: 2 for each number, and `STEP_COST` for each
    other item.
    """
    if isinstance(value, TEXT_TYPES):
        return len(value), len(value) >> 3
    total = visited = 0
    pending = [value]
    while pending:
        part = pending.pop()
        if isinstance(part, float):
            continue
        if isinstance(part, int):  # large integers count, since they might be converted to digits
            total += part.bit_length() // 64
        elif isinstance(part, TEXT_TYPES):
            total += len(part)
        elif isinstance(part, CONTAINER_TYPES):
            total += len(part)
            visited += STEP_COST + 2 * len(part)
            if total <= limit:
                previous_count = len(pending)
                total += nested_size(part, pending)
                if isinstance(part, dict):
                    visited += 2 * len(part)
                    total += nested_size(part.values(), pending)
                visited += STEP_COST * (len(pending) - previous_count)
        else:
            total += array_size(part)
            visited += array_size(part)
        if total > limit:
            break
    return total, visited


def array_size(value: Any) -> int:
    """Return the number of bytes of a numpy array, divided by eight, or 0 for other values."""
    return int(value.nbytes) >> 3 if type(value).__module__ == "numpy" and hasattr(value, "nbytes") else 0


def nested_size(items: Collection[Any], pending: list[Any]) -> int:
    """Return the total size of the items if all are integers, else 0; add items that must be visited one by one to
    `pending`.
    """
    item_types = set(map(type, items))
    if item_types == {int}:  # true for most messages
        bits: int = sum(number.bit_length() for number in items if not -_MAX_SMALL_INT < number < _MAX_SMALL_INT)
        return bits // 64
    if item_types <= _FIXED_SIZE:
        return 0
    pending.extend(items)
    return 0


def check_value(value: Any, limit: int = MAX_ITEMS) -> Any:
    """Check a computed value and return it unchanged.

    Args:
        value: the value.
        limit: maximum `size` of the value.

    Raises:
        ExpressionError: the value is larger, or is an integer of more than `MAX_BITS` bits.
    """
    check_limit(size(value, limit), limit)
    return check_bits(value)


def check_bits(value: Any) -> Any:
    """Check a computed value and return it unchanged.

    Raises:
        ExpressionError: the value is an integer of more than `MAX_BITS` bits.
    """
    if isinstance(value, int):
        check_limit(value.bit_length(), MAX_BITS)
    return value


def check_limit(needed: int, limit: int = MAX_ITEMS) -> None:
    """Check the size that a result would have.

    Raises:
        LimitError: `needed` is above `limit`.
    """
    if needed > limit:
        raise LimitError(TOO_LARGE)


def check_hashes(keys: Iterable[Any]) -> None:
    """Check the keys of a new set or dictionary, which would be very slow if many keys had the same hash.

    Raises:
        ExpressionError: more than `MAX_SAME_HASH` different keys have the same hash.
        TypeError: a key has no hash.
    """
    if isinstance(keys, (*TEXT_TYPES, dict, set, frozenset)):
        return  # hashes of strings cannot be predicted, and the other values were checked when they were created
    keys = list(keys)
    if len(keys) - len(set(map(hash, keys))) < MAX_SAME_HASH:
        return
    keys_by_hash: dict[int, list[Any]] = {}
    for key in keys:
        colliding = keys_by_hash.setdefault(hash(key), [])
        if key not in colliding:
            colliding.append(key)
            if len(colliding) > MAX_SAME_HASH:
                raise ExpressionError("too many keys have the same hash")
