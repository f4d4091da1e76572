"""``rospy disable``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Remove the file that offers the modules."""
    if args:
        raise UsageError("disable takes no arguments")
    from pyros1.drop_in.environment import disable, pth_file  # noqa: PLC0415

    print(f"removed {pth_file()}" if disable() else "was not enabled")


VERB = Verb(
    "disable", "undo rospy enable", examples=[("", "only programs that pyros1 starts find rospy")], stock="", run=run
)
