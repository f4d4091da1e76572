"""The program ``nodelet``: ``nodelet load`` and ``nodelet standalone`` run the node that does what a nodelet does."""

from __future__ import annotations

import os
import sys

from pyros1.finding.packages import PackageIndex
from pyros1.ground import names
from pyros1.ground.errors import PackageNotFoundError
from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.nodelet.matching import find_program, is_throttle, package_of

USAGE = """\
Usage: nodelet manager                      - Run a manager, which loads nothing: nodelets are nodes here
       nodelet load pkg/Type manager        - Run the node that does what the nodelet does
       nodelet standalone pkg/Type          - The same
       nodelet unload name manager          - Shut down such a node
"""
_NUM_OPERANDS = {"manager": 0, "load": 2, "standalone": 1, "unload": 2}


def main(argv: list[str]) -> int:
    """Run the program; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    rest = names.parse_arguments(argv[1:]).rest
    # roslaunch adds arguments at the end, so those of nodelet come first.
    remaps = [arg for arg in argv[1:] if arg not in rest]
    words = [arg for arg in rest if arg != "--no-bond"]
    verb = words[0] if words else ""
    if len(words) - 1 < _NUM_OPERANDS.get(verb, len(words)):
        sys.stderr.write(USAGE)
        return 1
    if verb == "manager":
        from pyros1.robot_nodes.nodelet.manager import main as run_manager  # noqa: PLC0415 - not for `load`

        return run_manager([argv[0], *remaps])
    if verb == "unload":
        return _dispatch("node", "kill", words[1])
    problem, package, program = _find(words[1])
    if problem and is_throttle(words[1]):
        from pyros1.robot_nodes.nodelet.throttle import main as run_throttle  # noqa: PLC0415 - not for others

        return run_throttle([argv[0], *words[1 + _NUM_OPERANDS[verb] :], *remaps])
    if problem:
        sys.stderr.write(f"ERROR: nodelet: {problem}\n")
        return 1
    return _dispatch("run", package, program, *words[1 + _NUM_OPERANDS[verb] :], *remaps)


def _find(class_name: str) -> tuple[str, str, str]:
    """Return what is wrong, or empty text, and the package and program for a nodelet's class."""
    shown, package = one_line(class_name, 100), package_of(class_name)
    if not package:
        return f"{shown!r} is not the class of a nodelet, such as image_proc/rectify", "", ""
    hint = "run a node with the same topics in its place, or this nodelet with stock ROS"
    index = PackageIndex(os.environ)
    try:
        program = find_program(class_name, index.executables(package))
    except PackageNotFoundError:
        return f"no package {one_line(package, 100)} for the nodelet {shown}: {hint}", package, ""
    return "" if program else f"no node here does what the nodelet {shown} does: {hint}", package, program


def _dispatch(*words: str) -> int:
    from pyros1.cli.dispatch import dispatch  # noqa: PLC0415 - not for `manager`

    return dispatch(["pyros1", *words], alone=True)
