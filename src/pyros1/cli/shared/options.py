"""Options shared by verbs of several commands."""

from __future__ import annotations

import os
from typing import Any

from pyros1.bag.limits import CHUNK_LIMIT_VARIABLE, DEFAULT_CHUNK_LIMIT, parse_limit
from pyros1.cli.records import Option
from pyros1.ground.errors import Error


def _set_chunk_limit(option: object, option_name: str, value: str, parser: Any) -> None:
    """Check the option's value, and set the environment variable that limits the size of the chunks to read."""
    try:
        parse_limit(value, option_name)
    except Error as error:
        parser.error(str(error))
    os.environ[CHUNK_LIMIT_VARIABLE] = value


CHUNK_LIMIT_OPTION = Option(
    "--chunk-limit",
    type="str",
    metavar="MIB",
    action="callback",
    callback=_set_chunk_limit,
    pyros1_only=True,
    help="refuse bag chunks that are larger than MIB mebibytes when uncompressed "
    f"(default {DEFAULT_CHUNK_LIMIT >> 20}, or ${CHUNK_LIMIT_VARIABLE})",
)
"""The option of all verbs that read bags."""
