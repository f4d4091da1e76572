"""Parses JSON from clients, and rejects values that are nested too deeply for recursive code (no I/O)."""

from __future__ import annotations

import json
from typing import Any

MAX_NESTING_DEPTH = 200
"""Maximum nesting depth of arrays and objects. Messages and parameters need only a few levels; XML-RPC allows 100."""


def loads(text: str | bytes) -> Any:
    """Parse a JSON document, and return its value.

    Raises:
        ValueError: the text is not JSON, or is nested too deeply.
    """
    try:
        value = json.loads(text)
    except RecursionError:  # some versions of Python limit the nesting, others do not
        raise ValueError("nested too deeply") from None
    openings = text.count("[") + text.count("{") if isinstance(text, str) else text.count(b"[") + text.count(b"{")
    if openings > MAX_NESTING_DEPTH and _is_too_deep(value):
        raise ValueError("nested too deeply")
    return value


def _is_too_deep(value: Any) -> bool:
    level = [value]
    for _ in range(MAX_NESTING_DEPTH):
        level = [
            child
            for parent in level
            if isinstance(parent, (dict, list))
            for child in (parent.values() if isinstance(parent, dict) else parent)
            if isinstance(child, (dict, list))
        ]
        if not level:
            return False
    return True
