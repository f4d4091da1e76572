"""Commands of pyros1 for faces whose stock twins are tools, too, as rosbag and rostopic"""

from __future__ import annotations

import sys
from importlib import import_module


def run(tool: str, *words: str) -> int:
    """Run a tool in this process, and return its exit code.

    The commands stand above this room, as users of the programs that it serves; so they are called by name, as a
    shell does.

    Args:
        tool: stock's name for it, for example ``rosbag``.
        words: what follows on the command line.
    """
    code: int = import_module("pyros1.cli.main").entry([tool, *words])
    return code


def main(tool: str, argv: list[str] | None = None) -> None:
    """Run a tool as its ``main`` does: with a command line whose first word is the program's name; then exit."""
    code = run(tool, *(sys.argv if argv is None else argv)[1:])
    if code:
        sys.exit(code)
