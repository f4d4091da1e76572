"""Shared code of the verbs about one node: the option ``-t`` and the check of the arguments."""

from __future__ import annotations

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Option

TIMEOUT = Option("-t", "--timeout", type="float", help="seconds to wait for the node (default: no limit)")


def check(args: list[str], *wanted: str, max_arguments: int | None = None) -> None:
    """Raise an error for too few or too many arguments.

    Args:
        args: the arguments.
        wanted: the name of each required argument, for errors.
        max_arguments: the maximum number of arguments, if optional ones are allowed.
    """
    if len(args) < len(wanted):
        raise UsageError(f"invalid arguments. Please specify {wanted[len(args)]}")
    if len(args) > (max_arguments or len(wanted)):
        raise UsageError("too many arguments")
