"""``pyros1 pkg``: finds packages like rospack (L182), manages files like rosbash (L184) and creates packages."""

from __future__ import annotations

import sys

from pyros1.cli import registry
from pyros1.cli.commands.pkg._rospack import run_tool
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command
from pyros1.cli.running import run_verb


def _dispatch(invocation: Invocation) -> int:
    """Run a verb. Options can precede the verbs of rospack. Return the exit code."""
    args = invocation.argv
    if args[:1] == ["--rosstack"]:
        return _run_rosstack(args[1:])
    entry = registry.verbs("pkg").get(args[0]) if args else None
    if entry is not None and not entry.in_stock_tool:
        return run_verb(registry.load_verb("pkg", args[0]), invocation)
    return run_tool(invocation)


def _run_rosstack(args: list[str]) -> int:
    """Run rosstack (L183), which only prints a note.

    The exit code for the verb ``profile`` is 0, since READMEs contain ``rospack profile && rosstack profile``.
    """
    print("rosstack: stacks belong to rosbuild; for packages, use rospack, which is pyros1 pkg", file=sys.stderr)
    return 0 if args[:1] == ["profile"] else 1


COMMAND = Command(
    "pkg",
    "find and create packages",
    group="develop",
    stock="rospack",
    other_programs={"roscreate-pkg": ["create"], "rosstack": ["--rosstack"]},
    heading="USAGE: {program} <command> [options] [package]\n  Allowed commands:",
    order=["help"],
    row="    {about}",
    footer="""  Extra options:
    -q     Quiets error reports.

 If [package] is omitted, the current working directory
 is used (if it contains a package.xml or manifest.xml).
""",
    dispatch=_dispatch,
)
