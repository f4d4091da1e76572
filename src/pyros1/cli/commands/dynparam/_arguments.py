"""Shared code of the verbs that take a node: the option ``-t``, and a check of the number of arguments."""

from __future__ import annotations

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Option

TIMEOUT_OPTION = Option("-t", "--timeout", type="float", help="seconds to wait for the node (default: no limit)")


def check_arguments(args: list[str], *required: str, max_arguments: int | None = None) -> None:
    """Check the number of arguments.

    Args:
        args: the arguments.
        required: the name of each required argument, for error messages.
        max_arguments: the maximum number of arguments if some are optional.

    Raises:
        UsageError: there are too few or too many arguments.
    """
    if len(args) < len(required):
        raise UsageError(f"invalid arguments. Please specify {required[len(args)]}")
    if len(args) > (max_arguments or len(required)):
        raise UsageError("too many arguments")
