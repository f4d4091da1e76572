"""Estimates how many steps it takes to match a regular expression with names of a given length (no I/O)."""

from __future__ import annotations

import importlib
import sys
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

MAX_NAME_LENGTH = 500
"""Maximum length of names that are matched with regular expressions."""
_MAX_STEPS = 3e6  # these take well below a second
_MANY = 1e12
_REPEATS = ("MAX_REPEAT", "MIN_REPEAT", "POSSESSIVE_REPEAT")
_Numbers = NDArray[np.float64]  # one number for each length: 0, 1, 2 ... characters


class _Part(NamedTuple):
    """Counts for a part of an expression, in the worst case: every character matches.

    Attributes:
        ways: in how many ways the part can match 0, 1, 2 ... characters.
        steps: how many of the part's steps end after 0, 1, 2 ... characters. Steps count even if the part then does not
            match: ``(a+)+b{450}`` matches no short names, but takes forever to find that out.
    """

    ways: _Numbers
    steps: _Numbers


def max_name_length(expression: str, min_length: int = 0) -> int:
    """Return the maximum length of names that can be matched within `_MAX_STEPS`, at most `MAX_NAME_LENGTH`.

    Args:
        expression: a valid regular expression.
        min_length: the minimum useful length. If a part of the expression already takes too many steps for it, counting
            stops, since it would take long, and the result is -1.
    """
    parser = importlib.import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")
    try:
        steps = _Counter(min_length).count_sequence(parser.parse(expression)).steps
    except _TooManyError:
        return -1
    return int(np.searchsorted(np.cumsum(steps), _MAX_STEPS, side="right")) - 1


class _TooManyError(Exception):
    pass


class _Counter:
    """Counts steps; raises _TooManyError if names of up to the minimum length already take too many."""

    def __init__(self, min_length: int) -> None:
        self._min_length = min_length

    def count_sequence(self, items: Any) -> _Part:
        ways, steps = _no_characters(), np.zeros(MAX_NAME_LENGTH + 1)
        for operation, argument in items:
            part = self._count(str(operation), argument)
            steps = self._checked(steps + _join(ways, part.steps))
            ways = _join(ways, part.ways)
        return _Part(ways, steps)

    def _count(self, operation: str, argument: Any) -> _Part:
        if operation in _REPEATS:
            low, high, body = argument
            low = min(int(low), MAX_NAME_LENGTH)  # more repeats cannot reduce the ways if the body can be empty
            return self._repeat(self.count_sequence(body), low, min(int(high), MAX_NAME_LENGTH))
        if operation in ("BRANCH", "GROUPREF_EXISTS"):
            branches = argument[1] if operation == "BRANCH" else argument[1:]
            parts = [self.count_sequence(branch or []) for branch in branches]
            steps = self._checked(sum((part.steps for part in parts), start=_no_characters()))
            return _Part(_limited(sum((part.ways for part in parts), start=np.zeros(MAX_NAME_LENGTH + 1))), steps)
        if operation in ("SUBPATTERN", "ATOMIC_GROUP"):
            return self.count_sequence(argument[-1] if operation == "SUBPATTERN" else argument)
        if operation in ("ASSERT", "ASSERT_NOT"):  # tried once, and consumes nothing
            direction, body = argument
            steps = self.count_sequence(body).steps
            if direction < 0:  # a lookbehind: assume that enough characters precede
                steps = _no_characters() * steps.sum()
            return _Part(_no_characters(), self._checked(_no_characters() + steps))
        if operation in ("AT", "GROUPREF"):  # the length of a reference is unknown; 0 is the worst case
            return _Part(_no_characters(), _no_characters())
        return _Part(np.roll(_no_characters(), 1), np.roll(_no_characters(), 1))

    def _repeat(self, body: _Part, low: int, high: int) -> _Part:
        widths = np.flatnonzero(body.ways)
        ways, before = np.zeros(MAX_NAME_LENGTH + 1), np.zeros(MAX_NAME_LENGTH + 1)
        if len(widths) == 1 and widths[0] and body.ways[widths[0]] == 1.0:  # such as x*
            ways[low * widths[0] : high * widths[0] + 1 : widths[0]] = 1.0
            before[: high * widths[0] : widths[0]] = 1.0
        else:
            power = _no_characters()
            for count in range(high + 1):
                if count >= low:
                    ways = _limited(ways + power)
                if count == high or not power.any():
                    break
                before = self._checked(before + power)
                power = _join(power, body.ways)
        return _Part(ways, self._checked(_no_characters() + _join(before, body.steps)))

    def _checked(self, steps: _Numbers) -> _Numbers:
        if steps[: self._min_length + 1].sum() > _MAX_STEPS:
            raise _TooManyError
        return _limited(steps)


def _join(first: _Numbers, second: _Numbers) -> _Numbers:
    """Return the numbers for two parts in sequence, given the numbers for each part."""
    return _limited(np.convolve(first, second)[: MAX_NAME_LENGTH + 1])


def _limited(numbers: _Numbers) -> _Numbers:
    return np.minimum(numbers, _MANY)


def _no_characters() -> _Numbers:
    numbers = np.zeros(MAX_NAME_LENGTH + 1)
    numbers[0] = 1.0
    return numbers
