"""What a misspelt word may have been meant to be."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return `` (did you mean 'x'?)`` to be put behind a message, or nothing if no word is near.

    Args:
        word: what was written.
        known: what could have been written.
    """
    close = difflib.get_close_matches(word, list(known), 1, 0.7)
    return f" (did you mean '{close[0]}'?)" if close and close[0] != word else ""
