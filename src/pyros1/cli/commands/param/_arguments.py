"""Shared code of the verbs: the option ``-v``, and the check of the number of arguments."""

from __future__ import annotations

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Flag

VERBOSE = Flag("-v", dest="verbose", help="turn on verbose output")


def check(args: list[str], max_arguments: int, missing: str = "") -> None:
    """Raise an error for too many arguments, or for none if one is required.

    Args:
        args: the arguments.
        max_arguments: the maximum number of arguments.
        missing: name of the first argument, if it is required.
    """
    if missing and not args:
        raise UsageError(f"invalid arguments. Please specify a {missing}")
    if len(args) > max_arguments:
        raise UsageError("too many arguments")
