"""``pyros1 pkg``: rospack (L182, L183), files of packages as rosbash finds them (L184), and making packages."""

from __future__ import annotations

from pyros1.cli import registry
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command
from pyros1.cli.running import run_verb
from pyros1.cli.shared.rospack.tool import run_tool


def _dispatch(invocation: Invocation) -> int:
    """Run a verb. rospack's options may come before it."""
    words = invocation.argv
    entry = registry.verbs("pkg").get(words[0]) if words else None
    if entry is not None and not entry.of_tool:
        return run_verb(registry.load_verb("pkg", words[0]), invocation)
    return run_tool(invocation, "pkg")


COMMAND = Command(
    "pkg",
    "find and create packages",
    group="develop",
    stock="rospack",
    also={"roscreate-pkg": ["create"]},
    heading="USAGE: {program} <command> [options] [package]\n  Allowed commands:",
    order=["help"],
    row="    {about}",
    footing="""  Extra options:
    -q     Quiets error reports.

 If [package] is omitted, the current working directory
 is used (if it contains a package.xml or manifest.xml).
""",
    dispatch=_dispatch,
)
