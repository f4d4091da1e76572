"""``pyros1 unsetup``: takes back what ``setup`` did."""

from __future__ import annotations

from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command, Verb
from pyros1.cli.shared.shells import SHELL, chosen_shell, how_to_use, parse_shell


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print what takes the setup back."""
    shell = chosen_shell(invocation, options)
    if shell is not None:
        print(shell.undo())


COMMAND = Command(
    "unsetup",
    "take back what setup did to this shell",
    Verb(
        "",
        "",
        SHELL,
        description="Takes back what `pyros1 setup` did to this shell.",
        examples=how_to_use("unsetup"),
        parse=parse_shell,
        run=run,
    ),
    group="machine",
)
