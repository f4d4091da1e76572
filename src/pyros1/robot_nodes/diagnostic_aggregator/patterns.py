"""Regular expressions for names that others choose, in bounded time (no I/O).

Python tries all ways in which an expression can match, and lets no other thread run meanwhile: ``(a+)+`` needs years to
see that it does not match 50 times ``a`` and a ``b``. So the steps are counted beforehand.
"""

from __future__ import annotations

import re
from functools import lru_cache

from pyros1.ground.errors import Error

MIN_NAME_LENGTH = 40
"""An expression that takes too long for names of this length is refused."""
MAX_EXPRESSION_LENGTH = 1000
_CACHED_NAMES = 10_000


class PatternError(Error):
    """A regular expression cannot be used."""


class NamePattern:
    """A regular expression for complete names.

    Args:
        expression: in Python's syntax.

    Attributes:
        max_length: the maximum length of names, since longer ones would take too long; they do not match.

    Raises:
        PatternError: it is not a regular expression, or takes too long.
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
