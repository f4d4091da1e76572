"""How much of a bag is believed: a file of some kilobytes may claim to hold anything. Loads nothing else of bags.

What is believed costs memory (`tests/bag/test_memory.py` and `test_limits.py` hold these factors):

- a large message at most three times its size, read, shown, copied, packed or encrypted;
- a text in which a character needs more than a byte up to six times: Python's strings then have as many bytes for all;
- a list of numbers what Python's lists take, which is eight bytes and the number for each element;
- a chunk of many small messages four times its content.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from pyros1.errors import Error

CHUNK_LIMIT = 256 << 20
"""Largest content of a chunk that is read unless told otherwise, in bytes: a small file may claim anything."""

_MOST_MIB = 4096

LIMIT_VARIABLE = "PYROS1_BAG_CHUNK_LIMIT"
"""Environment variable with another limit, in MiB."""


def chunk_limit(environ: Mapping[str, str]) -> int:
    """Return the largest content of a chunk that is read, in bytes.

    Raises:
        Error: the variable's value is not a number of MiB.
    """
    text = environ.get(LIMIT_VARIABLE)
    return parse_limit(text, LIMIT_VARIABLE) if text else CHUNK_LIMIT


def parse_limit(text: str, name: str) -> int:
    """Return a limit in MiB as bytes.

    Args:
        text: the number.
        name: of the option or variable, for the error.

    Raises:
        Error: it is no number, or bags cannot hold so large chunks.
    """
    if not re.fullmatch("[0-9]{1,4}", text) or not 0 < int(text) < _MOST_MIB:
        raise Error(f"{name}: {text[:20]!r} is not a number of MiB from 1 to {_MOST_MIB - 1}")
    return int(text) << 20
