"""Suggests corrections for misspelt words, options and remappings."""

from __future__ import annotations

import re
from collections.abc import Iterable

from pyros1.ground.terminal_text import one_line

_DASHES = "\u2010\u2011\u2012\u2013\u2014\u2015\u2212\ufe58\ufe63\uff0d"
_DASHED_OPTION = rf"([-{_DASHES}]{{1,2}})([A-Za-z][\w-]*)((?:=.*)?)"
_ASSIGNMENT = r"([~/]?\w[\w/]*)(=:|:(?![:/\\=\s])|=(?![=:\s]))(.+)"
_MIN_PORT = 1024
_MIN_SIMILARITY = 0.6
_MIN_PREFIX_LENGTH = 2
SYNONYMS = {"ls": "list", "rm": "delete", "cat": "echo", "show": "info", "stack": "pkg"}
"""Words that other tools use -> pyros1's words."""


def did_you_mean(word: str, valid_words: Iterable[str]) -> str:
    """Return `` (did you mean 'x'?)``, to be appended to a message, or an empty string if no valid word is similar.

    Args:
        word: the word that was written.
        valid_words: the words that could have been meant.
    """
    from difflib import get_close_matches  # noqa: PLC0415 - rarely needed

    words = list(valid_words)
    candidates = [SYNONYMS[word]] if SYNONYMS.get(word) in words else []
    candidates = candidates or [candidate for candidate in words if candidate.casefold() == word.casefold()]
    candidates = candidates or get_close_matches(word, words, 5, 0.7)
    suggestion = next((candidate for candidate in candidates if word in SYNONYMS or _is_similar(word, candidate)), "")
    suggestion = suggestion or _find_completion(word, words) or word
    return f" (did you mean '{one_line(suggestion)}'?)" if suggestion != word else ""


def _find_completion(word: str, words: list[str]) -> str:
    """Return the only one of `words` that begins with `word`, or an empty string if there is none or more than one."""
    completions = {candidate for candidate in words if candidate.casefold().startswith(word.casefold())}
    return (
        completions.pop()
        if len(completions) == 1 and len(word.strip("/")) >= _MIN_PREFIX_LENGTH and word[-1:] != "/"
        else ""
    )


def _is_similar(word: str, other: str) -> bool:
    """Return whether two names are similar even without the parts that they share, such as the package or a file
    extension.
    """
    from difflib import SequenceMatcher  # noqa: PLC0415

    word_parts, other_parts = re.split(r"[/.]", word.casefold()), re.split(r"[/.]", other.casefold())
    for end in (0, -1):
        while len(word_parts) > 1 and len(other_parts) > 1 and word_parts[end] == other_parts[end]:
            del word_parts[end], other_parts[end]
    return SequenceMatcher(None, "/".join(word_parts), "/".join(other_parts)).ratio() >= _MIN_SIMILARITY


def similar_option(word: str) -> str | None:
    """Return the option that was probably meant by an argument that begins with a typographic dash, or None.

    Args:
        word: the command-line argument, for example one that was copied from a PDF.
    """
    if word.isascii():
        return None
    match = re.fullmatch(_DASHED_OPTION, word, re.DOTALL)
    if match is None or match[1].isascii():
        return None
    dashes = "-" if len(match[2]) == 1 else "--"
    return dashes + match[2] + match[3]


def similar_remapping(word: str) -> str | None:
    """Return the remapping or parameter that was probably meant by an argument with half of ``:=`` missing, or None.

    Args:
        word: the command-line argument, for example ``_rate=10`` or ``rate:10``. A possible ``host:port`` gives None.
    """
    if ":=" in word or not (":" in word or "=" in word):
        return None
    match = re.fullmatch(_ASSIGNMENT, word, re.ASCII | re.DOTALL)
    if match is None or match[1][0].isdigit():
        return None
    name, sign, value = match.groups()
    if sign == ":" and value.isdigit() and int(value[:6]) >= _MIN_PORT:
        return None
    return f"{name}:={value}"


def argument_hint(word: str) -> str:
    """Return a hint if an argument looks like a misspelt option or remapping; otherwise an empty string.

    Args:
        word: the command-line argument.
    """
    option = similar_option(word)
    if option is not None:
        return f"'{word}' begins with a typographic dash, not with '-': write {option}"
    remapping = similar_remapping(word)
    return f"'{word}' is neither a remapping nor a parameter: write {remapping}" if remapping is not None else ""
