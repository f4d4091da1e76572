"""Private parameters on the command line: ``_rate:=10`` sets ``~rate`` to the number 10 (N13: YAML rules, as rospy)."""

from __future__ import annotations

import re
from typing import Any

_INT = re.compile(r"[-+]?(0|[1-9][0-9]*)\Z")
_FLOAT = re.compile(r"[-+]?[0-9]+\.[0-9]*\Z")
_WORD = re.compile(r"[A-Za-z/_][\w/.-]*\Z", re.ASCII)
_KEYWORDS = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"}


def private_parameter(text: str) -> Any:
    """Return the value of a parameter given as text.

    Plain numbers and words are seen at once; for the rest the YAML reader is loaded. Text that is no YAML is a string.
    """
    if _INT.match(text):
        return int(text)
    if _FLOAT.match(text):
        return float(text)
    if _WORD.match(text) and text.lower() not in _KEYWORDS:
        return text
    from pyros1.errors import Error  # noqa: PLC0415 - with the next
    from pyros1.values import load_yaml  # noqa: PLC0415 - takes 20 ms to load

    try:
        value = load_yaml(text)
    except Error:
        return text
    return "" if value is None else value
