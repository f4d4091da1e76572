"""Prints JSON, and decides whether to print colours."""

from __future__ import annotations

import os
from typing import Any, TextIO

from pyros1.ground import terminal_text


def print_json(value: Any) -> None:
    """Print a value as one line of JSON."""
    import json  # noqa: PLC0415

    print(terminal_text.json_text(json.dumps(value, ensure_ascii=False)))


def should_use_colour(stream: TextIO) -> bool:
    """Return whether a stream is a terminal with colours and NO_COLOR is not set (https://no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
