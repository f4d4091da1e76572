"""Memory limits for reading bags, since even a small file can claim any size. Imports no other modules from `bag`.

Within the limits, reading needs this much memory (checked by `tests/bag/test_memory.py` and `test_limits.py`):

- to read, print, copy, compress or encrypt a large message: at most three times its size;
- for a string with multi-byte characters: up to six times its size, since Python then stores all characters with the
size of the largest;
- for a list of numbers: as much as Python needs, eight bytes and a number object for each element;
- for a chunk of many small messages: four times the size of its content.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from pyros1.ground.errors import Error

DEFAULT_CHUNK_LIMIT = 256 << 20
"""Default limit for the size of a chunk's content, in bytes."""

_MAX_MIB = 4096

CHUNK_LIMIT_VARIABLE = "PYROS1_BAG_CHUNK_LIMIT"
"""Name of the environment variable that overrides the limit, in MiB."""


def chunk_limit(environ: Mapping[str, str]) -> int:
    """Return the maximum size of a chunk's content, in bytes.

    Raises:
        Error: the variable's value is not a number of MiB.
    """
    text = environ.get(CHUNK_LIMIT_VARIABLE)
    return parse_limit(text, CHUNK_LIMIT_VARIABLE) if text else DEFAULT_CHUNK_LIMIT


def parse_limit(text: str, name: str) -> int:
    """Convert a limit from MiB to bytes.

    Args:
        text: the number of MiB.
        name: name of the option or variable, for the error message.

    Raises:
        Error: the text is not a number, or the limit would be larger than any chunk can be.
    """
    if not re.fullmatch("[0-9]{1,4}", text) or not 0 < int(text) < _MAX_MIB:
        raise Error(f"{name}: {text[:20]!r} is not a number of MiB from 1 to {_MAX_MIB - 1}")
    return int(text) << 20
