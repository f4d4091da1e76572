"""Shared code of the verbs of ``param``: the option ``-v``, and a check of the number of arguments."""

from __future__ import annotations

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Flag

VERBOSE_FLAG = Flag("-v", dest="verbose", help="turn on verbose output")


def check_arguments(args: list[str], max_arguments: int, first_argument: str = "") -> None:
    """Check the number of arguments.

    Args:
        args: the arguments.
        max_arguments: the maximum number of arguments.
        first_argument: the name of the first argument for the error message; empty if the argument is optional.

    Raises:
        UsageError: a required argument is missing, or there are too many.
    """
    if first_argument and not args:
        raise UsageError(f"invalid arguments. Please specify a {first_argument}")
    if len(args) > max_arguments:
        raise UsageError("too many arguments")
