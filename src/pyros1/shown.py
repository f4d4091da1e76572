"""What others sent, made fit for a terminal.

A name, an error text or a message of another process may hold escape sequences, which move the cursor, change the
window's title or hide text, line breaks, which forge lines of ours, and marks that turn the direction of writing round.
Whatever came from elsewhere passes through here before a person sees it. Each such character is shown as Python would
write it in a string: ``\\x1b``.
"""

from __future__ import annotations

import re

_STEERING = "\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff"
_CONTROLS = _STEERING + "\ud800-\udfff"  # and what cannot be encoded
# Compiled when a text needs them, which few do: every command and node starts sooner.
_BUT_BYTES = f"\r(?!\n)|(?!\r)[{_STEERING}]"
_IN_LINES = f"\r(?!\n)|(?!\r)[{_CONTROLS}]"
_IN_ONE_LINE = f"[\t\n{_CONTROLS}]"
_BUT_COLOURS = f"(\x1b\\[[0-9;]*m)|\r(?!\n)|(?!\r)[{_CONTROLS}]"


def one_line(value: object, most: int = 1000) -> str:
    """Return what a value says as one line without control characters, for names and for parts of sentences.

    Args:
        value: what ``str`` makes a text of.
        most: characters to show; the rest of a longer text is left out, which is said.
    """
    text = str(value)
    if len(text) > most:
        text = f"{text[:most]}... ({len(text) - most} more characters)"
    return text if text.isprintable() else re.sub(_IN_ONE_LINE, _escape, text)


def lines(text: str, *, keep_bytes: bool = False) -> str:
    """Return a text without control characters but line breaks and tabs, which are taken to be ours.

    Args:
        keep_bytes: keep what stands for bytes that are no text, in names of files.
    """
    if text.replace("\n", "").isprintable():  # as nearly all are; much quicker than to look for what is not
        return text
    return re.sub(_BUT_BYTES if keep_bytes else _IN_LINES, _escape, text)


def coloured_lines(text: str) -> str:
    """Return the same with colours: for texts that a program writes itself, as those of its log."""
    if text.replace("\n", "").isprintable():
        return text
    return re.sub(_BUT_COLOURS, lambda found: found.group(1) or _escape(found), text)


class Foreign(str):
    """A text of others that stays what it is for programs, as a name to look up or a value in JSON, but shows itself as
    `one_line` in what is printed and formatted. Strings that are joined or added show what is in them: join ``map(str,
    names)``.
    """

    __slots__ = ()

    def __str__(self) -> str:
        return one_line(str.__str__(self), len(self))

    def __format__(self, spec: str) -> str:
        return format(str(self), spec)


def foreign(text: str) -> str:
    """Return a text of others to be shown and used; the same object if nothing in it does harm."""
    return text if text.isprintable() or not re.search(_IN_ONE_LINE, text) else Foreign(text)


def json_text(text: str) -> str:
    """Return JSON with control characters, which JSON allows in strings, in the form that stands for them."""
    return (
        text
        if text.isascii() and "\x7f" not in text
        else re.sub(_IN_LINES, lambda found: f"\\u{ord(found.group()):04x}", text)
    )


def _escape(found: re.Match[str]) -> str:
    return repr(found.group())[1:-1]
