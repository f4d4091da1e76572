"""Values to YAML text: the layout, quoting and line folding that scripts around the ROS 1 tools have come to expect.

Block style puts a sequence below its key without extra indentation, folds at single spaces beyond column 80 and prefers
plain, then single-quoted, then double-quoted scalars. Everything outside printable ASCII is escaped.
"""

from __future__ import annotations

import base64
import datetime
import math
import re
from typing import Any

from pyros1.values.reading import YamlError
from pyros1.values.scalars import scalar_tag

_WIDTH = 80
_STEP = 2
_LONGEST_SIMPLE_KEY = 128 - len("!!str") - 1
_TIMESTAMP_SEPARATOR = " "
_NEEDS_ESCAPES = re.compile(r"[^\n\x20-\x7e]")
_SPACE_AT_BREAK = re.compile(r" \n|\n ")
_NOT_PLAIN_ANYWHERE = re.compile(r"""^[#,\[\]{}&*!|>'"%@`]|^-(?:\s|$)|^(?:---|\.\.\.)|^[?:](?:\s|$)|:(?:\s|$)|\s#""")
_NOT_PLAIN_INLINE = re.compile(r"[,?\[\]{}:]")
_ESCAPES = {
    "\0": "0", "\x07": "a", "\x08": "b", "\t": "t", "\n": "n", "\x0b": "v", "\x0c": "f", "\r": "r", "\x1b": "e",
    '"': '"', "\\": "\\", "\x85": "N", "\xa0": "_", "\u2028": "L", "\u2029": "P",
}  # fmt: skip


class Writer:
    """Writes one document.

    Args:
        block: block style if True, else inline.
    """

    def __init__(self, block: bool) -> None:
        self._block = block
        self._out: list[str] = []
        self._column = 0
        self._open: set[int] = set()

    def document(self, value: Any) -> str:
        """Return `value` as a document; see `pyros1.values.dump_yaml`."""
        try:
            inline = not self._block and isinstance(value, dict | list | tuple)
            plain = self._value(value, 0 if self._is_block(value) else _STEP, inline=inline)
        except RecursionError as error:
            raise YamlError("cannot write as YAML: nested too deeply") from error
        if self._column:
            self._break()
        if plain:
            self._put("...")
            self._break()
        return "".join(self._out)

    # Output primitives ---------------------------------------------------------------------------------------------

    def _put(self, text: str) -> None:
        self._out.append(text)
        self._column += len(text)

    def _break(self, indent: int = 0) -> None:
        self._out.append("\n" + " " * indent)
        self._column = indent

    # Nodes ---------------------------------------------------------------------------------------------------------

    def _is_block(self, value: Any) -> bool:
        return self._block and isinstance(value, dict | list | tuple) and len(value) > 0

    def _items(self, value: dict[Any, Any]) -> list[tuple[Any, Any]]:
        items = list(value.items())
        try:
            return sorted(items, key=lambda item: item[0])
        except TypeError:  # keys of several types have no order
            return items

    def _value(self, value: Any, indent: int, *, inline: bool, key: bool = False) -> bool:
        """Write `value`, continuation lines (or entries) at `indent`; return whether it is a plain scalar."""
        if isinstance(value, dict | list | tuple):
            if id(value) in self._open:
                raise YamlError("cannot write as YAML: a value contains itself")
            self._open.add(id(value))
            if not value:
                self._put("{}" if isinstance(value, dict) else "[]")
            elif inline or not self._is_block(value):
                self._inline(value, indent)
            elif isinstance(value, dict):
                self._mapping(value, indent)
            else:
                self._sequence(value, indent)
            self._open.discard(id(value))
            return False
        if isinstance(value, bytes | bytearray):
            self._binary(bytes(value), indent, inline=inline or key)
            return False
        if isinstance(value, str):
            return self._string(value, indent, inline=inline, key=key)
        self._put(_plain_scalar(value))
        return True

    def _mapping(self, value: dict[Any, Any], indent: int) -> None:
        for number, (key, item) in enumerate(self._items(value)):
            if number:
                self._break(indent)
            if _is_simple_key(key):
                self._value(key, indent + _STEP, inline=False, key=True)
                self._put(":")
            else:
                self._put("? ")
                self._value(key, indent + _STEP, inline=False)
                self._break(indent)
                self._put(":")
                if self._is_block(item):
                    self._put(" ")
                    self._value(item, indent + _STEP, inline=False)
                    continue
            if not self._is_block(item):
                self._put(" ")
                self._value(item, indent + _STEP, inline=False)
            elif isinstance(item, dict):
                self._break(indent + _STEP)
                self._value(item, indent + _STEP, inline=False)
            else:
                self._break(indent)
                self._value(item, indent, inline=False)

    def _sequence(self, value: Any, indent: int) -> None:
        for number, item in enumerate(value):
            if number:
                self._break(indent)
            self._put("- ")
            self._value(item, indent + _STEP, inline=False)

    def _inline(self, value: Any, indent: int) -> None:
        self._put("{" if isinstance(value, dict) else "[")
        entries = self._items(value) if isinstance(value, dict) else [(None, item) for item in value]
        for number, (key, item) in enumerate(entries):
            if number:
                self._put(",")
            if self._column > _WIDTH:
                self._break(indent)
            elif number:
                self._put(" ")
            if isinstance(value, dict):
                self._inline_key(key, indent)
            self._value(item, indent + _STEP, inline=True)
        self._put("}" if isinstance(value, dict) else "]")

    def _inline_key(self, key: Any, indent: int) -> None:
        if _is_simple_key(key):
            self._value(key, indent + _STEP, inline=True, key=True)
            self._put(": ")
            return
        self._put("? ")
        self._value(key, indent + _STEP, inline=True)
        if self._column > _WIDTH:
            self._break(indent)
        else:
            self._put(" ")
        self._put(": ")

    # Scalars -------------------------------------------------------------------------------------------------------

    def _string(self, text: str, indent: int, *, inline: bool, key: bool) -> bool:
        edges = text[:1] in (" ", "\n") or text[-1:] in (" ", "\n")
        double_only = bool(_NEEDS_ESCAPES.search(text) or _SPACE_AT_BREAK.search(text))
        tag = scalar_tag(text)
        readable = tag in ("str", "degrees", "radians")
        plain = readable and not edges and not double_only and "\n" not in text and not _NOT_PLAIN_ANYWHERE.search(text)
        if plain and not (inline and _NOT_PLAIN_INLINE.search(text)):
            self._folded(text, indent, fold=not key, ends=True)
            return True
        if double_only or (key and "\n" in text):
            self._double_quoted(text, indent, fold=not key)
            return False
        self._put("'")
        self._folded(text.replace("'", "''"), indent, fold=not key, ends=False)
        self._put("'")
        return False

    def _folded(self, text: str, indent: int, *, fold: bool, ends: bool) -> None:
        """Write plain or single-quoted text; a single space beyond the width becomes a line break."""
        position = 0
        for match in re.finditer(r" +|\n+", text):
            self._put(text[position : match.start()])
            position = match.end()
            gap = match.group()
            if gap[0] == "\n":
                self._out.append("\n")
                for _ in gap[1:]:
                    self._out.append("\n")
                self._break(indent)
            elif gap == " " and fold and self._column > _WIDTH and (ends or 0 < match.start() < len(text) - 1):
                self._break(indent)
            else:
                self._put(gap)
        self._put(text[position:])

    def _double_quoted(self, text: str, indent: int, *, fold: bool) -> None:
        self._put('"')
        start = 0  # of the run of characters that need no escape and are not written yet
        for end in range(len(text) + 1):
            char = text[end] if end < len(text) else None
            if char is None or char in '"\\\x85\u2028\u2029\ufeff' or not " " <= char <= "~":
                self._put(text[start:end])
                start = end
                if char is not None:
                    self._put(_escape(char))
                    start = end + 1
            too_long = fold and self._column + (end - start) > _WIDTH
            if too_long and 0 < end < len(text) - 1 and (char == " " or start >= end):
                if start < end:
                    self._put(text[start:end])
                    start = end
                self._put("\\")
                self._break(indent)
                if text[start] == " ":
                    self._put("\\")
        self._put('"')

    def _binary(self, data: bytes, indent: int, *, inline: bool) -> None:
        text = base64.encodebytes(data).decode("ascii")
        if inline or not text:
            self._put("!!binary ")
            self._double_quoted(text, indent, fold=True)
            return
        self._put("!!binary |")
        for line in text.splitlines():
            self._break(indent)
            self._put(line)


def _is_simple_key(key: Any) -> bool:
    if isinstance(key, str):
        return 0 < len(key) <= _LONGEST_SIMPLE_KEY and "\n" not in key
    return not isinstance(key, bytes | bytearray | tuple)


def _plain_scalar(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return _float_text(value)
    if isinstance(value, datetime.datetime):
        return value.isoformat(_TIMESTAMP_SEPARATOR)
    if isinstance(value, datetime.date):
        return value.isoformat()
    raise YamlError(f"cannot write as YAML: a value of type {type(value).__name__}")


def _float_text(value: float) -> str:
    if math.isnan(value):
        return ".nan"
    if math.isinf(value):
        return ".inf" if value > 0 else "-.inf"
    text = repr(float(value)).lower()
    # Without the dot a YAML 1.1 reader takes 1e+17 for a string.
    return text.replace("e", ".0e", 1) if "." not in text else text


def _escape(char: str) -> str:
    if char in _ESCAPES:
        return "\\" + _ESCAPES[char]
    code = ord(char)
    if code <= 0xFF:
        return f"\\x{code:02X}"
    return f"\\u{code:04X}" if code <= 0xFFFF else f"\\U{code:08X}"
