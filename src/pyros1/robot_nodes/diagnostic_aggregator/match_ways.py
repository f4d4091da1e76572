"""Counts the ways in which a regular expression can match names of some length (no I/O)."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAX_NAME_LENGTH = 500
"""Maximum length of a name that a regular expression is tried on."""
_MAX_WAYS = 1e6  # well below a second
_MANY = 1e12
_REPEATS = ("MAX_REPEAT", "MIN_REPEAT", "POSSESSIVE_REPEAT")
_Ways = NDArray[np.float64]  # in how many ways 0, 1, 2 ... characters can be matched


def max_name_length(expression: str) -> int:
    """Return for which length of names there are at most a million ways to match, up to `MAX_NAME_LENGTH`.

    Args:
        expression: a valid regular expression.
    """
    parser = importlib.import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")
    ways = _count_sequence(parser.parse(expression))
    return int(np.searchsorted(np.cumsum(ways), _MAX_WAYS, side="right")) - 1


def _count_sequence(items: Any) -> _Ways:
    ways = _no_characters()
    for operation, argument in items:
        ways = _join(ways, _count(str(operation), argument))
    return ways


def _count(operation: str, argument: Any) -> _Ways:
    """Return the ways of a part of an expression, if each character could match."""
    if operation in _REPEATS:
        low, high, body = argument
        low = min(int(low), MAX_NAME_LENGTH)  # more repeats of what can be empty have no fewer ways
        return _repeat(_count_sequence(body), low, min(int(high), MAX_NAME_LENGTH))
    if operation in ("BRANCH", "GROUPREF_EXISTS"):
        branches = argument[1] if operation == "BRANCH" else argument[1:]
        return _limited(
            sum((_count_sequence(branch or []) for branch in branches), start=np.zeros(MAX_NAME_LENGTH + 1))
        )
    if operation in ("SUBPATTERN", "ATOMIC_GROUP"):
        return _count_sequence(argument[-1] if operation == "SUBPATTERN" else argument)
    if operation in ("ASSERT", "ASSERT_NOT"):
        return _limited(_no_characters() * _count_sequence(argument[1]).sum())
    if operation in ("AT", "GROUPREF"):  # how long a reference is, is not known: none is the worst case
        return _no_characters()
    return np.roll(_no_characters(), 1)


def _repeat(body: _Ways, low: int, high: int) -> _Ways:
    widths = np.flatnonzero(body)
    ways = np.zeros(MAX_NAME_LENGTH + 1)
    if len(widths) == 1 and widths[0] and body[widths[0]] == 1.0:  # such as x*
        ways[low * widths[0] : high * widths[0] + 1 : widths[0]] = 1.0
        return ways
    power = _no_characters()
    for count in range(high + 1):
        if count >= low:
            ways = _limited(ways + power)
        if not power.any():
            break
        power = _join(power, body)
    return ways


def _join(first: _Ways, second: _Ways) -> _Ways:
    """Return in how many ways two parts, one after the other, can match."""
    return _limited(np.convolve(first, second)[: MAX_NAME_LENGTH + 1])


def _limited(ways: _Ways) -> _Ways:
    return np.minimum(ways, _MANY)


def _no_characters() -> _Ways:
    ways = np.zeros(MAX_NAME_LENGTH + 1)
    ways[0] = 1.0
    return ways
