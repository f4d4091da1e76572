"""``pyros1 unsetup``: reverts ``pyros1 setup`` in a shell."""

from __future__ import annotations

from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command, Verb
from pyros1.cli.shared.shells import SHELL_OPTION, parse_shell, select_shell, usage_examples


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the shell code that reverts the setup."""
    shell = select_shell(invocation, options)
    if shell is not None:
        print(shell.undo())


COMMAND = Command(
    "unsetup",
    "undo `pyros1 setup` in this shell",
    Verb(
        "",
        "",
        SHELL_OPTION,
        description="Prints shell code that undoes `pyros1 setup` in this shell.",
        examples=usage_examples("unsetup"),
        parse=parse_shell,
        run=run,
    ),
    group="machine",
)
