"""``pyros1 stack``: rosstack (L183)."""

from __future__ import annotations

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command
from pyros1.cli.shared.rospack.tool import run_tool


def _dispatch(invocation: Invocation) -> int:
    """Run a verb. Options may come before it."""
    return run_tool(invocation, "stack")


COMMAND = Command(
    "stack",
    "find stacks",
    group="develop",
    stock="rosstack",
    heading="USAGE: {program} [options] <command> [stack]\n  Allowed commands:",
    order=[
        "help", "find", "contents", "list", "list-names", "depends", "depends-manifests", "depends1", "depends-indent",
        "depends-why", "depends-on", "depends-on1", "contains", "contains-path", "profile",
    ],
    row="    {about}",
    footing="\n If [stack] is omitted, the current working directory\n is used (if it contains a stack.xml).\n",
    dispatch=_dispatch,
)  # fmt: skip
