"""Shared code of the verbs: the option ``-v`` and argument checks."""

from __future__ import annotations

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Flag

VERBOSE_FLAG = Flag("-v", dest="verbose", help="turn on verbose output")


def check_arguments(args: list[str], max_arguments: int, required: str = "") -> None:
    """Check the number of arguments.

    Args:
        args: the arguments.
        max_arguments: the maximum number of arguments.
        required: the name of the first argument if it is required.

    Raises:
        UsageError: a required argument is missing, or there are too many.
    """
    if required and not args:
        raise UsageError(f"invalid arguments. Please specify a {required}")
    if len(args) > max_arguments:
        raise UsageError("too many arguments")
