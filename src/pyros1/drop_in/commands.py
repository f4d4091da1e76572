"""Runs pyros1's commands for modules that are also tools in stock ROS, such as rosbag and rostopic."""

from __future__ import annotations

import sys
from importlib import import_module


def run(tool: str, *words: str) -> int:
    """Run a tool in this process, and return its exit code.

    The commands are in a higher layer, which must not be imported statically: they are called by name, as in a shell.

    Args:
        tool: the name of the tool in stock ROS, for example ``rosbag``.
        words: the command-line arguments.
    """
    code: int = import_module("pyros1.cli.main").entry([tool, *words])
    return code


def main(tool: str, argv: list[str] | None = None) -> None:
    """Run a tool in this process, and exit with its exit code if that is not 0.

    Args:
        tool: the name of the tool in stock ROS, for example ``rosbag``.
        argv: the command line, which starts with the program's name; None for `sys.argv`.
    """
    code = run(tool, *(sys.argv if argv is None else argv)[1:])
    if code:
        sys.exit(code)
