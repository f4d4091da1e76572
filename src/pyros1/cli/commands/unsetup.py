"""``pyros1 unsetup``: undoes ``setup``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command, Verb
from pyros1.cli.shared.shells import SHELL, chosen_shell, how_to_use, parse_shell


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the shell code that undoes the setup."""
    shell = chosen_shell(invocation, options)
    if shell is not None:
        print(shell.undo())


COMMAND = Command(
    "unsetup",
    "undo setup in this shell",
    Verb(
        "",
        "",
        SHELL,
        description="Prints shell code that undoes `pyros1 setup` in this shell.",
        examples=how_to_use("unsetup"),
        parse=parse_shell,
        run=run,
    ),
    group="machine",
)
