"""Makes text from elsewhere safe to print in a terminal.

A name, an error or a message from another process can contain escape sequences, which move the cursor, change the
window's title or hide text; line breaks, which fake lines of output; and characters that reverse the text direction.
Text from elsewhere must pass through one of these functions before it is displayed. They escape each such character as
in a Python string: ``\\x1b``.
"""

from __future__ import annotations

import re

_CONTROL_CHARACTERS = "\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff"
_UNPRINTABLE = _CONTROL_CHARACTERS + "\ud800-\udfff"  # with surrogates, which cannot be encoded
# Compiled when a text needs them, which is rare, so that commands and nodes start faster.
_EXCEPT_BYTES = f"\r(?!\n)|(?!\r)[{_CONTROL_CHARACTERS}]"
_IN_LINES = f"\r(?!\n)|(?!\r)[{_UNPRINTABLE}]"
_IN_ONE_LINE = f"[\t\n{_UNPRINTABLE}]"
_EXCEPT_COLOURS = f"(\x1b\\[[0-9;]*m)|\r(?!\n)|(?!\r)[{_UNPRINTABLE}]"


def one_line(value: object, max_length: int = 1000) -> str:
    """Return a value as one line without control characters, for names and parts of sentences.

    Args:
        value: anything that can be converted with ``str``.
        max_length: maximum number of characters; the rest of a longer text is replaced with a note about its length.
    """
    text = str(value)
    if len(text) > max_length:
        text = f"{text[:max_length]}... ({len(text) - max_length} more characters)"
    return text if text.isprintable() else re.sub(_IN_ONE_LINE, _escape, text)


def lines(text: str, *, keep_bytes: bool = False) -> str:
    """Return ``text`` without control characters other than line breaks and tabs, which are assumed to be intended.

    Args:
        keep_bytes: whether to keep the surrogates that represent undecodable bytes in file names.
    """
    if text.replace("\n", "").isprintable():  # true for nearly all texts, and much faster than a search
        return text
    return re.sub(_EXCEPT_BYTES if keep_bytes else _IN_LINES, _escape, text)


def coloured_lines(text: str) -> str:
    """Return ``text`` like `lines`, but keep colours: for text that the program itself writes, such as log messages."""
    if text.replace("\n", "").isprintable():
        return text
    return re.sub(_EXCEPT_COLOURS, lambda match: match.group(1) or _escape(match), text)


class UntrustedText(str):
    """A string from elsewhere. Code can use its value, for example to look up a name or write JSON, but it is escaped
    as by `one_line` when it is printed or formatted. ``join`` and ``+`` use the raw value: join ``map(str, names)``
    instead.
    """

    __slots__ = ()

    def __str__(self) -> str:
        return one_line(str.__str__(self), len(self))

    def __format__(self, spec: str) -> str:
        return format(str(self), spec)


def untrusted(text: str) -> str:
    """Return a string from elsewhere as `UntrustedText`, or unchanged if it is harmless."""
    return text if text.isprintable() or not re.search(_IN_ONE_LINE, text) else UntrustedText(text)


def json_text(text: str) -> str:
    """Return JSON text with all control characters escaped, including those that JSON allows in strings."""
    return (
        text
        if text.isascii() and "\x7f" not in text
        else re.sub(_IN_LINES, lambda match: f"\\u{ord(match.group()):04x}", text)
    )


def _escape(match: re.Match[str]) -> str:
    return repr(match.group())[1:-1]
