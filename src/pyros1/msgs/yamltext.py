"""Writes strings as YAML, character for character like PyYAML's default emitter.

Programs parse the output of ``rostopic echo``, so quoting and the folding of long strings are part of the interface.
Messages need only two forms: a single string, always in double quotes, and a block sequence of strings, each plain if
YAML 1.1 would read it back as a string, otherwise quoted. https://yaml.org/spec/1.1/

PyYAML is not used here, although the tests compare all output with it: its emitter is five to eight times slower for
short strings, such as each field in `echo`, and keeps several copies of a long string in memory, while this emitter
yields the string in pieces. Its fast variant, libyaml, folds at different positions.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

_FOLD_COLUMN = 80
_MAX_PIECE_LENGTH = 9999
"""Maximum length of a piece without a space, in characters."""
_INDENT = "\n  "

_ESCAPES = {
    "\0": "0",
    "\a": "a",
    "\b": "b",
    "\t": "t",
    "\n": "n",
    "\v": "v",
    "\f": "f",
    "\r": "r",
    "\x1b": "e",
    '"': '"',
    "\\": "\\",
    "\x85": "N",
    "\xa0": "_",
    "\u2028": "L",
    "\u2029": "P",
}

# Plain scalars that YAML 1.1 does not read as strings.
_NOT_A_STRING_PATTERN = re.compile(
    r"""(?: yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF
    | ~|null|Null|NULL|<<|=
    | [-+]?0b[01_]+ | [-+]?0[0-7_]+ | [-+]?(?:0|[1-9][0-9_]*) | [-+]?0x[0-9a-fA-F_]+
    | [-+]?[1-9][0-9_]*(?::[0-5]?[0-9])+
    | [-+]?[0-9][0-9_]*\.[0-9_]*(?:[eE][-+][0-9]+)? | \.[0-9][0-9_]*(?:[eE][-+][0-9]+)?
    | [-+]?[0-9][0-9_]*(?::[0-5]?[0-9])+\.[0-9_]* | [-+]?\.(?:inf|Inf|INF) | \.(?:nan|NaN|NAN)
    | [0-9]{4}-[0-9]{2}-[0-9]{2}
    | [0-9]{4}-[0-9][0-9]?-[0-9][0-9]?(?:[Tt]|[\ \t]+)[0-9][0-9]?:[0-9]{2}:[0-9]{2}(?:\.[0-9]*)?
      (?:[\ \t]*(?:Z|[-+][0-9][0-9]?(?::[0-9][0-9])?))?
    )\Z""",
    re.VERBOSE,
)
_INDICATOR_PATTERN = re.compile(r"---|\.\.\.|[#,\[\]{}&*!|>'\"%@`]|[-?:](?:\s|\Z)|(?s:.)*(?::(?:\s|\Z)|\s#)")
_ASCII_ONLY_PATTERN = re.compile(r"[\n\x20-\x7e]*\Z")
_RUN_PATTERN = re.compile(r" +|\n+|[^ \n']{1,9999}|'")


def quoted_pieces(text: str, column: int = 0) -> Iterator[str]:
    """Yield a string in double quotes, folded after column 80, in small pieces of YAML.

    Args:
        text: any string.
        column: column of the opening quote.
    """
    yield '"'
    column += 1
    start = 0
    last = len(text) - 1
    for end, character in enumerate(text):
        if character in '"\\' or not " " <= character <= "~":
            escape = _escape(character)
            yield text[start:end] + escape
            column += end - start + len(escape)
            start = end + 1
        elif end - start >= _MAX_PIECE_LENGTH:
            yield text[start : end - 1]  # keeps one character back: a fold at `end` needs text before it
            column += end - 1 - start
            start = end - 1
        if 0 < end < last and (character == " " or start >= end) and column + end - start > _FOLD_COLUMN:
            yield text[start:end] + "\\" + _INDENT
            column = 2
            start = max(start, end)
            if text[start] == " ":
                yield "\\"
                column += 1
    yield text[start:]
    yield '"'


def item_pieces(text: str) -> Iterator[str]:
    """Yield an element of a block sequence in small pieces.

    The element begins in column 2, and its further lines are indented to that column.
    """
    if not text:
        return iter(("''",))
    if not _ASCII_ONLY_PATTERN.match(text) or re.search(r" \n|\n ", text):
        return quoted_pieces(text, 2)
    is_plain = (
        "\n" not in text
        and text.strip() == text
        and not _INDICATOR_PATTERN.match(text)
        and not _NOT_A_STRING_PATTERN.match(text)
    )
    return _folded(text, 2) if is_plain else _single_quoted(text)


def _single_quoted(text: str) -> Iterator[str]:
    yield "'"
    yield from _folded(text, 3, quoted=True)
    yield "'"


def _folded(text: str, column: int, *, quoted: bool = False) -> Iterator[str]:
    """Yield the text, folded at single spaces after column 80; if quoted, with quotes and line breaks doubled."""
    position = 0
    for match in _RUN_PATTERN.finditer(text):
        run = match[0]
        position = match.end()
        if run == " " and column > _FOLD_COLUMN and not (quoted and position == len(text)):
            yield _INDENT
            column = 2
        elif run[0] == "\n":
            yield "\n" + run + _INDENT[1:]
            column = 2
        else:
            output = "''" if quoted and run == "'" else run
            yield output
            column += len(output)


def _escape(character: str) -> str:
    letter = _ESCAPES.get(character)
    if letter is not None:
        return "\\" + letter
    code = ord(character)
    return f"\\x{code:02X}" if code <= 0xFF else f"\\u{code:04X}" if code <= 0xFFFF else f"\\U{code:08X}"
