"""How large the values of an expression may get, and the error of one that is wrong or gets too large."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from pyros1.errors import Error

MAX_TEXT = 10_000
"""Most characters of an expression."""

MAX_ITEMS = 10_000
"""Most characters or items of a calculated value, those of the values inside it included."""

MAX_BITS = 4096
"""Most bits of a calculated integer."""

MAX_WORK = 10_000_000
"""Most work of an expression: what its operations and functions go through counts one for each item, or for eight
characters of a text; besides, each part that is calculated counts `STEP`, as often as comprehensions go through it."""

STEP = 6
"""What it costs to calculate one part of an expression, one item of a comprehension, or to look into a list."""

CALL = 16
"""What a call costs, besides what the function does."""

TOO_MUCH = "there is too much to calculate; look at fewer fields or items"
MAX_SAME_HASH = 100
"""Most keys of a set or dictionary that have the same hash, as the multiples of 2**61 - 1 have."""

_WEIGHTLESS = frozenset({bool, float, type(None)})
SCALARS = _WEIGHTLESS | {int}
_SMALL = 1 << 63
TEXTS = (str, bytes, bytearray)
_VIEWS: tuple[type[Any], ...] = (type({}.keys()), type({}.values()), type({}.items()))
CONTAINERS: tuple[type[Any], ...] = (list, tuple, dict, set, frozenset, *_VIEWS)
HASHED: tuple[type[Any], ...] = (dict, set, frozenset, type({}.keys()), type({}.items()))


class ExpressionError(Error, ValueError):
    """An expression is malformed, uses what is not allowed, gets too large, or fails; the text says which."""


def size(value: Any, limit: int = MAX_ITEMS) -> int:
    """Count the characters and items of a value and of those inside it, each as often as it appears.

    Args:
        value: anything; an integer counts as many as it has times 64 bits, what is no text or container nothing.
        limit: counting stops beyond this.

    Returns:
        The size, or any number above `limit`.
    """
    return measure(value, limit)[0]


def measure(value: Any, limit: int = MAX_ITEMS) -> tuple[int, int]:
    """Return the `size` of a value and how many items had to be looked at to know it."""
    if isinstance(value, TEXTS):
        return len(value), len(value) >> 3
    total = looks = 0
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
            looks += STEP + len(part)
            if total <= limit:
                total += inside(part, pending)
                if isinstance(part, dict):
                    looks += len(part)
                    total += inside(part.values(), pending)
        if total > limit:
            break
    return total, looks


def inside(items: Collection[Any], pending: list[Any]) -> int:
    """Return how many items integers count beyond 64 bits, and put to `pending` what has to be looked at one by one."""
    kinds = set(map(type, items))
    if kinds == {int}:  # as in most messages
        large: int = sum(number.bit_length() for number in items if not -_SMALL < number < _SMALL)
        return large // 64
    if kinds <= _WEIGHTLESS:
        return 0
    pending.extend(items)
    return 0


def bounded(value: Any, limit: int = MAX_ITEMS) -> Any:
    """Return a calculated value unchanged.

    Args:
        value: the value.
        limit: its greatest `size`.

    Raises:
        ExpressionError: it is larger than that, or an integer of more than `MAX_BITS` bits.
    """
    require(size(value, limit), limit)
    return check_bits(value)


def check_bits(value: Any) -> Any:
    """Return a calculated value unchanged.

    Raises:
        ExpressionError: it is an integer of more than `MAX_BITS` bits.
    """
    if isinstance(value, int):
        require(value.bit_length(), MAX_BITS)
    return value


def require(needed: int, limit: int = MAX_ITEMS) -> None:
    """Check a size before what has it is made.

    Raises:
        ExpressionError: `needed` is above `limit`.
    """
    if needed > limit:
        raise ExpressionError("the result is too large")


def spread(keys: Iterable[Any]) -> None:
    """Check what will be the keys of a set or dictionary, which takes for ever if they have the same hash.

    Raises:
        ExpressionError: more than `MAX_SAME_HASH` different ones have.
        TypeError: one has no hash.
    """
    if isinstance(keys, (*TEXTS, dict, set, frozenset)):
        return  # of texts nobody knows the hash beforehand, and the others were checked when they were made
    found: dict[int, list[Any]] = {}
    for key in keys:
        same = found.setdefault(hash(key), [])
        if key not in same:
            same.append(key)
            if len(same) > MAX_SAME_HASH:
                raise ExpressionError("too many keys have the same hash")
