"""Limits on the memory for a bag, as a small file may claim any size. Does not import other modules of bags.

Within the limits, reading takes this much memory (checked by `tests/bag/test_memory.py` and `test_limits.py`):

- a large message at most three times its size, to read, print, copy, compress or encrypt it;
- a string with characters of several bytes up to six times: Python then uses that many bytes for all its characters;
- a list of numbers as much as in Python: eight bytes and a number object for each element;
- a chunk of many small messages four times the size of its content.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from pyros1.ground.errors import Error

CHUNK_LIMIT = 256 << 20
"""Default limit of a chunk's content, in bytes."""

_MAX_MIB = 4096

LIMIT_VARIABLE = "PYROS1_BAG_CHUNK_LIMIT"
"""Name of the environment variable with another limit, in MiB."""


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
        text: the number of MiB.
        name: name of the option or variable, for the error message.

    Raises:
        Error: it is not a number, or larger than chunks can be.
    """
    if not re.fullmatch("[0-9]{1,4}", text) or not 0 < int(text) < _MAX_MIB:
        raise Error(f"{name}: {text[:20]!r} is not a number of MiB from 1 to {_MAX_MIB - 1}")
    return int(text) << 20
