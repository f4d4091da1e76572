"""How large the values of an expression may get, and the error of one that is wrong or gets too large."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pyros1.errors import Error

MAX_TEXT = 10_000
"""Most characters of an expression."""

MAX_ITEMS = 10_000
"""Most characters or items of a calculated value, those of the values inside it included."""

MAX_BITS = 4096
"""Most bits of a calculated integer."""

MAX_STEPS = 100_000
"""Most items that the comprehensions of an expression go through, all together."""

MAX_WORK = 5_000_000
"""Most items that an expression's operations and functions go through, all together; eight characters are one."""

MAX_SAME_HASH = 100
"""Most keys of a set or dictionary that have the same hash, as the multiples of 2**61 - 1 have."""

_TEXTS = (str, bytes, bytearray)
_VIEWS: tuple[type[Any], ...] = (type({}.keys()), type({}.values()), type({}.items()))
_CONTAINERS: tuple[type[Any], ...] = (list, tuple, dict, set, frozenset, *_VIEWS)


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
    if isinstance(value, _TEXTS):
        return len(value)
    total = 0
    pending = [value]
    while pending:
        part = pending.pop()
        if isinstance(part, float):
            continue
        if isinstance(part, int):  # its digits may become text
            total += part.bit_length() // 64
        elif isinstance(part, _TEXTS):
            total += len(part)
        elif isinstance(part, _CONTAINERS):
            total += len(part)
            if total <= limit:
                pending.extend(part)
                pending.extend(part.values() if isinstance(part, dict) else ())
        if total > limit:
            break
    return total


def bounded(value: Any, limit: int = MAX_ITEMS) -> Any:
    """Return a calculated value unchanged.

    Args:
        value: the value.
        limit: its greatest `size`.

    Raises:
        ExpressionError: it is larger than that, or an integer of more than `MAX_BITS` bits.
    """
    require(size(value, limit), limit)
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
    if isinstance(keys, (*_TEXTS, dict, set, frozenset)):
        return  # of texts nobody knows the hash beforehand, and the others were checked when they were made
    found: dict[int, list[Any]] = {}
    for key in keys:
        same = found.setdefault(hash(key), [])
        if key not in same:
            same.append(key)
            if len(same) > MAX_SAME_HASH:
                raise ExpressionError("too many keys have the same hash")


def work(value: Any) -> int:
    """Return how many items an operation goes through that reads the whole value; eight characters are one."""
    if isinstance(value, _TEXTS):
        return len(value) // 8
    items: Any = value
    return len(items) if isinstance(value, _CONTAINERS) else 0
