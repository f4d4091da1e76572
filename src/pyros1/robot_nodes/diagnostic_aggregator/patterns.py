"""Matches regular expressions with untrusted names in bounded time (no I/O).

Python tries all ways in which an expression can match, and lets no other thread run meanwhile: for ``(a+)+``, it takes
years to find out that 50 ``a`` followed by a ``b`` do not match. So the steps are counted beforehand.
"""

from __future__ import annotations

import re
from functools import lru_cache

from pyros1.ground.errors import Error

MIN_NAME_LENGTH = 40
"""An expression that takes too long for names of this length is rejected."""
MAX_EXPRESSION_LENGTH = 1000
_CACHED_NAMES = 10_000


class PatternError(Error):
    """A regular expression cannot be used."""


class NamePattern:
    """A regular expression for complete names.

    Args:
        expression: in Python's syntax.

    Attributes:
        max_length: the maximum length of names. Longer ones would take too long, so they never match.

    Raises:
        PatternError: the expression is invalid, or takes too long to match.
    """

    def __init__(self, expression: str) -> None:
        if len(expression) > MAX_EXPRESSION_LENGTH:
            raise PatternError(f"it is longer than {MAX_EXPRESSION_LENGTH} characters")
        # Imported here, since it needs numpy, and most robots have no regular expressions.
        from pyros1.robot_nodes.diagnostic_aggregator.match_ways import max_name_length  # noqa: PLC0415

        try:
            pattern = re.compile(expression)
            self.max_length = max_name_length(expression, MIN_NAME_LENGTH)
        except (re.error, OverflowError, RecursionError) as error:
            raise PatternError(str(error)) from error
        if self.max_length < MIN_NAME_LENGTH:
            raise PatternError(
                "it could take hours, since too much in it has a variable length: "
                "use fewer of * + ? {}, and none in another"
            )
        self._fullmatch = lru_cache(_CACHED_NAMES)(lambda name: pattern.fullmatch(name) is not None)

    def matches(self, name: str) -> bool:
        """Return whether the whole name matches. Results are cached, since the same names recur."""
        return len(name) <= self.max_length and self._fullmatch(name)
