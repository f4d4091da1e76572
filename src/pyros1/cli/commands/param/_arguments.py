"""What the verbs share: the option ``-v``, and how many arguments there may be."""

from __future__ import annotations

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Flag

VERBOSE = Flag("-v", dest="verbose", help="turn on verbose output")


def check(args: list[str], most: int, missing: str = "") -> None:
    """Refuse too many arguments, and none where something is needed.

    Args:
        args: the arguments.
        most: how many there may be.
        missing: what the first one is, if it is needed.
    """
    if missing and not args:
        raise UsageError(f"invalid arguments. Please specify a {missing}")
    if len(args) > most:
        raise UsageError("too many arguments")
