"""``pyros1 setup``: makes the stock command names available in one shell.

``source <(pyros1 setup)`` puts a folder of small programs on the shell's PATH, one per stock name, and adds functions
and completion. Each installation of pyros1 has its own folder.
"""

from __future__ import annotations

import os
from typing import Any

from pyros1.cli import registry
from pyros1.cli.commands.setup._programs import make_programs
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command, Verb
from pyros1.cli.shared.shells import SHELL_OPTION, CompletedNames, parse_shell, select_shell, usage_examples


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write the programs, and print the shell code that sets up a shell."""
    shell = select_shell(invocation, options)
    if shell is not None:
        args_by_program = registry.stock_names()
        folder = make_programs(args_by_program, os.environ)
        print(shell.setup(str(folder), CompletedNames([*args_by_program, "pyros1"])), end="")


COMMAND = Command(
    "setup",
    "set up a shell: source <(pyros1 setup) adds rostopic, roscd and other ROS 1 commands, and completion",
    Verb(
        "",
        "",
        SHELL_OPTION,
        description="Prints shell code that adds the names of ROS 1's commands (rostopic, roscd, ...) and completion.",
        examples=usage_examples("setup"),
        parse=parse_shell,
        run=run,
    ),
    group="machine",
)
