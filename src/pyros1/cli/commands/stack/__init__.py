"""``pyros1 stack``: rosstack (L183)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
from pyros1.cli.records import Command, Verb
from pyros1.cli.shared.rospack import QUIET, run_tool


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Run a verb; options may stand before it."""
    return run_tool(invocation, "stack")


COMMAND = Command(
    "stack",
    "find stacks",
    Verb("", "", QUIET, parse=leave_words, run=run),
    group="develop",
    stock="rosstack",
    heading="USAGE: {program} [options] <command> [stack]\n  Allowed commands:",
    order=[
        "help", "find", "contents", "list", "list-names", "depends", "depends-manifests", "depends1", "depends-indent",
        "depends-why", "depends-on", "depends-on1", "contains", "contains-path", "profile",
    ],
    row="    {about}",
    footing="\n If [stack] is omitted, the current working directory\n is used (if it contains a stack.xml).\n",
)  # fmt: skip
