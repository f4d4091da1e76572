"""Limits on the values and the work of expressions, and the error of expressions."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from pyros1.ground.errors import Error

MAX_TEXT = 10_000
"""Maximum number of characters of an expression."""

MAX_ITEMS = 10_000
"""Maximum number of characters or items of a computed value, with those of nested values."""

MAX_BITS = 4096
"""Maximum number of bits of a computed integer."""

MAX_WORK = 10_000_000
"""Maximum work of an expression. Operations and functions count one for each item that they visit, or for eight
characters of a string; in addition, each evaluation of a node counts `STEP`."""

STEP = 6
"""Cost to evaluate a node or an item of a comprehension, or to access an item of a list."""

CALL = 30
"""Cost of a call, in addition to that of the function."""

TOO_EXPENSIVE = "the expression takes too much work; use fewer fields or items"
TOO_LARGE = "the result is too large; use fewer fields, items or characters"
MAX_SAME_HASH = 100
"""Maximum number of keys of a set or dictionary with the same hash, such as the multiples of 2**61 - 1."""

_FIXED_SIZE = frozenset({bool, float, type(None)})
SCALARS = _FIXED_SIZE | {int}
_SMALL = 1 << 63
TEXTS = (str, bytes, bytearray)
_VIEWS: tuple[type[Any], ...] = (type({}.keys()), type({}.values()), type({}.items()))
CONTAINERS: tuple[type[Any], ...] = (list, tuple, dict, set, frozenset, *_VIEWS)
HASHED: tuple[type[Any], ...] = (dict, set, frozenset, type({}.keys()), type({}.items()))


class ExpressionError(Error, ValueError):
    """An expression is malformed, not allowed, too large, or fails; the message says which."""


class LimitError(ExpressionError):
    """A value of an expression would be too large, or its evaluation too much work."""


class UnknownNameError(ExpressionError):
    """An expression has a name that it cannot use."""


def size(value: Any, limit: int = MAX_ITEMS) -> int:
    """Return the number of characters and items of a value and of nested values, each as often as it occurs.

    Args:
        value: any value; an integer counts one for each 64 bits, an array one for each 64 bits of its items, and other
            values that are not strings or containers 0.
        limit: number at which counting stops.

    Returns:
        The size, or any number above `limit`.
    """
    return measure(value, limit)[0]


def measure(value: Any, limit: int = MAX_ITEMS) -> tuple[int, int]:
    """Return the `size` of a value, and the work to make it: two for each number, and `STEP` for each other item."""
    if isinstance(value, TEXTS):
        return len(value), len(value) >> 3
    total = visited = 0
    pending = [value]
    while pending:
        part = pending.pop()
        if isinstance(part, float):
            continue
        if isinstance(part, int):  # its digits may become text
            total += part.bit_length() // 64
        elif isinstance(part, TEXTS):
            total += len(part)
        elif isinstance(part, CONTAINERS):
            total += len(part)
            visited += STEP + 2 * len(part)
            if total <= limit:
                before = len(pending)
                total += nested_size(part, pending)
                if isinstance(part, dict):
                    visited += 2 * len(part)
                    total += nested_size(part.values(), pending)
                visited += STEP * (len(pending) - before)
        else:
            total += array_size(part)
            visited += array_size(part)
        if total > limit:
            break
    return total, visited


def array_size(value: Any) -> int:
    """Return the number of bytes of an array of numpy, divided by eight; 0 for other values."""
    return int(value.nbytes) >> 3 if type(value).__module__ == "numpy" and hasattr(value, "nbytes") else 0


def nested_size(items: Collection[Any], pending: list[Any]) -> int:
    """Return the number for integers beyond 64 bits, and add to `pending` the items that must be visited separately."""
    kinds = set(map(type, items))
    if kinds == {int}:  # as in most messages
        large: int = sum(number.bit_length() for number in items if not -_SMALL < number < _SMALL)
        return large // 64
    if kinds <= _FIXED_SIZE:
        return 0
    pending.extend(items)
    return 0


def checked(value: Any, limit: int = MAX_ITEMS) -> Any:
    """Return a computed value unchanged, after a check.

    Args:
        value: the value.
        limit: its largest `size`.

    Raises:
        ExpressionError: it is larger, or an integer of more than `MAX_BITS` bits.
    """
    require(size(value, limit), limit)
    return check_bits(value)


def check_bits(value: Any) -> Any:
    """Return a computed value unchanged, after a check.

    Raises:
        ExpressionError: it is an integer of more than `MAX_BITS` bits.
    """
    if isinstance(value, int):
        require(value.bit_length(), MAX_BITS)
    return value


def require(needed: int, limit: int = MAX_ITEMS) -> None:
    """Check the size of a result before it is made.

    Raises:
        LimitError: `needed` is above `limit`.
    """
    if needed > limit:
        raise LimitError(TOO_LARGE)


def check_hashes(keys: Iterable[Any]) -> None:
    """Check the keys of a new set or dictionary, which would be very slow if they had the same hash.

    Raises:
        ExpressionError: more than `MAX_SAME_HASH` different keys have the same hash.
        TypeError: a key has no hash.
    """
    if isinstance(keys, (*TEXTS, dict, set, frozenset)):
        return  # hashes of strings cannot be predicted, and the others were checked when they were made
    keys = list(keys)
    if len(keys) - len(set(map(hash, keys))) < MAX_SAME_HASH:
        return
    found: dict[int, list[Any]] = {}
    for key in keys:
        same = found.setdefault(hash(key), [])
        if key not in same:
            same.append(key)
            if len(same) > MAX_SAME_HASH:
                raise ExpressionError("too many keys have the same hash")
