"""What verbs about one node share: the option ``-t``, and which arguments there must be."""

from __future__ import annotations

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Option

TIMEOUT = Option("-t", "--timeout", type="float", help="seconds to wait for the node (default: without end)")


def check(args: list[str], *wanted: str, most: int | None = None) -> None:
    """Refuse too few and too many arguments.

    Args:
        args: the arguments.
        wanted: what each necessary one is.
        most: how many there may be, if more than these.
    """
    if len(args) < len(wanted):
        raise UsageError(f"invalid arguments. Please specify {wanted[len(args)]}")
    if len(args) > (most or len(wanted)):
        raise UsageError("too many arguments")
