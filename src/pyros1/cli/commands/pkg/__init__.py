"""``pyros1 pkg``: rospack (L182), files of packages as rosbash finds them (L184), and creation of packages."""

from __future__ import annotations

import sys

from pyros1.cli import registry
from pyros1.cli.commands.pkg._rospack import run_tool
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command
from pyros1.cli.running import run_verb


def _dispatch(invocation: Invocation) -> int:
    """Run a verb. rospack's options may come before it."""
    words = invocation.argv
    if words[:1] == ["--rosstack"]:
        return _stack(words[1:])
    entry = registry.verbs("pkg").get(words[0]) if words else None
    if entry is not None and not entry.of_tool:
        return run_verb(registry.load_verb("pkg", words[0]), invocation)
    return run_tool(invocation)


def _stack(words: list[str]) -> int:
    """Run rosstack (L183). Its `profile` is no error: READMEs contain ``rospack profile && rosstack profile``."""
    print("rosstack: stacks were rosbuild's; for packages use rospack, which is pyros1 pkg", file=sys.stderr)
    return 0 if words[:1] == ["profile"] else 1


COMMAND = Command(
    "pkg",
    "find and create packages",
    group="develop",
    stock="rospack",
    also={"roscreate-pkg": ["create"], "rosstack": ["--rosstack"]},
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
