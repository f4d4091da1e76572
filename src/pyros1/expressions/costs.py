"""What operations and functions cost: about how many items they go through, known before they do.

A message counts with all that is in it; what goes through a value only once on its surface counts less than what
compares, sorts or shows it. Where an operation may look at every pair of items, the pairs count.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pyros1.expressions.functions import name_of, owner_of
from pyros1.expressions.limits import CONTAINERS, HASHED, SCALARS, STEP, TEXTS, inside

_PLAIN = SCALARS - {int}
_PAIRS = 64
"""How many pairs of characters count as one item."""
_GLANCE = frozenset({"get", "has", "isinstance", "len"})
"""Functions that do not go through their arguments."""
_SURFACE = frozenset({"all", "any", "bool", "enumerate", "filter", "list", "map", "reversed", "sum", "tuple", "zip"})
"""Functions that go through the items of a value, but not into them."""
_BRIEF = frozenset({"endswith", "get", "items", "keys", "startswith", "values"})
"""Methods that do not go through the value that they are of."""
_PRECISE = frozenset({"fsum", "gcd", "lcm", "isqrt", "dist", "sumprod", "hypot", "round", "divmod"})
"""Functions that do much with each number, or with each 64 bits of one."""
_PRECISE_FACTOR = 20
_FIELD = 8
"""What one field of a format text costs, besides what is shown."""


def surface(value: Any) -> int:
    """Return how many items there are on the surface of a value; eight characters are one."""
    kind = type(value)
    if kind in SCALARS:
        return 0
    if kind in TEXTS:
        return len(value) >> 3
    return len(value) if isinstance(value, CONTAINERS) else 0


def depth(value: Any, limit: int) -> int:
    """Return how many items there are in a value and in those inside it, each as often as it appears.

    Args:
        value: anything; eight characters are one item (in a message each of a text's, which are quoted one by one when
            it is shown), 64 bits of a large integer, too.
        limit: counting stops beyond this.
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
    """Count a message and put its fields to `pending`, or count what another library made."""
    if type(value).__module__ == "numpy":
        return int(value.size)
    slots = getattr(type(value), "__slots__", ())
    pending.extend(getattr(value, name, None) for name in slots)
    return STEP * (1 + len(slots))


def call(function: Callable[..., Any], arguments: Sequence[Any], keywords: Mapping[str, Any], limit: int) -> int:
    """Return what a call goes through.

    Args:
        function: what is called.
        arguments: its arguments.
        keywords: those that have a name.
        limit: counting stops beyond this.
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
    if name == "format":  # each field may show everything again
        return int(owner.count("{")) * (_FIELD + inside)
    if type(owner) not in TEXTS:
        return depth(owner, limit)
    return surface(owner) + sum(sought(argument, owner) for argument in arguments)


def sought(text: Any, where: Any) -> int:
    """Return what it costs to look for a text in another, or to strip its characters from it: the pairs count."""
    if type(text) not in TEXTS or type(where) not in TEXTS:
        return 0
    return len(text) * len(where) // _PAIRS


def contained(item: Any, where: Any, limit: int) -> int:
    """Return what ``item in where`` costs."""
    if type(where) in TEXTS:
        return surface(where) + sought(item, where)
    if isinstance(where, HASHED):
        return depth(item, limit)  # its hash
    return surface(where) if type(item) in SCALARS else depth(where, limit)


def binary(op: ast.operator, left: Any, right: Any, limit: int) -> int:
    """Return what an operator between two values costs, besides what it makes."""
    if isinstance(op, ast.Mod) and isinstance(left, str):  # each field may show everything again
        return surface(left) + left.count("%") * (_FIELD + depth(right, limit))
    if type(left) is int and type(right) is int:
        return (left.bit_length() + right.bit_length()) >> 8
    return surface(left) + surface(right)
