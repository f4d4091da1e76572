"""The output formats of ``topic echo`` and ``bag export``: text, JSON and rows of values (L61, L62).

A message may be large and its output several times larger, so the output is written in chunks.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import Any

from pyros1.bag.export.tables import Table
from pyros1.cli.shared.buffered_output import BufferedOutput, WriteFunction
from pyros1.cli.shared.printing import should_use_colour
from pyros1.ground.terminal_text import json_text, lines
from pyros1.ground.timing import Time
from pyros1.msgs import Message
from pyros1.msgs.text import emit_message

ValueWriter = Callable[[Message, Any, "str | None", WriteFunction], object]
"""Writes a value from a message. The arguments are the message, the value, its type from `FieldPath.get`, and a
function that writes a string."""

_CLEAR_SCREEN = "\033[2J\033[;H"
_FIELD_NAME = re.compile(r"^( *(?:- )?)([A-Za-z]\w*):(?=$| )", re.M)
"""Matches a field name at the beginning of a line."""


class TextFormat:
    """Writes messages as YAML-like text, each followed by ``---`` (L61)."""

    def __init__(self, options: Any, now: Callable[[], Time]) -> None:
        self._prefix = _CLEAR_SCREEN if options.clear else ""
        self._make_transform = _make_colouring_transform if should_use_colour(sys.stdout) else _make_plain_transform
        self._now = now if options.offset else None
        self._settings: dict[str, Any] = {
            "no_string": bool(options.nostr),
            "no_array": bool(options.noarr),
            "width": options.width,
        }

    def __call__(self, message: Message, value: Any, type_name: str | None, write: WriteFunction) -> None:
        if self._prefix:
            write(self._prefix)
        offset = self._now() if self._now else None
        with BufferedOutput(write, self._make_transform()) as out:
            emit_message(out.add, value, type_name=type_name, time_offset=offset, **self._settings)
            out.add("\n---\n")


def _make_plain_transform() -> Callable[[str], str]:
    return lines


def _make_colouring_transform() -> Callable[[str], str]:
    """Return a function that escapes and colours the chunks of a message, which may end in the middle of a line."""
    at_start = True

    def transform(text: str) -> str:
        nonlocal at_start
        begin = 0 if at_start else text.find("\n") + 1 or len(text)
        at_start = text.endswith("\n")
        return lines(text[:begin]) + _FIELD_NAME.sub("\\1\033[36m\\2\033[0m:", lines(text[begin:]))

    return transform


class JsonFormat:
    """Writes messages as lines of JSON."""

    def __init__(self, options: Any) -> None:
        self._excludes_strings, self._excludes_arrays = bool(options.nostr), bool(options.noarr)

    def __call__(
        self, message: Message, value: Any, type_name: str | None, write: WriteFunction, end: str = "\n"
    ) -> None:
        from pyros1.msgs.json_form import emit_json  # noqa: PLC0415

        with BufferedOutput(write, json_text) as out:
            emit_json(out.add, value, type_name, includes=self._is_included)
            out.add(end)

    def _is_included(self, type_name: str) -> bool:
        return not (self._excludes_arrays and "[" in type_name) and not (
            self._excludes_strings and type_name.partition("[")[0] == "string"
        )


class PlotFormat:
    """Writes messages as rows of comma-separated values after a row of names (L62)."""

    def __init__(self, options: Any, now: Callable[[], Time]) -> None:
        self._now = now
        self._shows_offsets = bool(options.offset)
        self._uses_bag_time = bool(options.bag)
        self._table = Table(omits_strings=bool(options.nostr), omits_arrays=bool(options.noarr))
        self._has_written_header = False

    def __call__(self, message: Message, value: Any, type_name: str | None, write: WriteFunction) -> None:
        now = self._now()
        uses_stamp = not self._uses_bag_time and type_name is None and getattr(message, "_has_header", False)
        stamp = message.header.stamp if uses_stamp else now  # type: ignore[attr-defined] # checked by _has_header
        nanoseconds = stamp.to_nsec() - (now.to_nsec() if self._shows_offsets else 0)
        with BufferedOutput(write, lines) as out:
            if not self._has_written_header:
                self._has_written_header = True
                self._table.emit_header(value, out.add)
            self._table.emit_message(value, nanoseconds, out.add, now if self._shows_offsets else None)
