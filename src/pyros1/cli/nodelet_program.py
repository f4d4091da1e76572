"""The program ``nodelet``: ``nodelet load`` and ``nodelet standalone`` run a node that replaces the nodelet."""

from __future__ import annotations

import os
import sys

from pyros1.finding.nodelet_programs import OPERANDS, NodeletError, check_arguments, is_throttle, locate_nodelet
from pyros1.finding.packages import PackageIndex
from pyros1.ground import names

USAGE = """\
Usage: nodelet manager                      - Run a manager; it loads nothing, since nodes replace nodelets
       nodelet load pkg/Type manager        - Run the node that replaces the nodelet
       nodelet standalone pkg/Type          - The same
       nodelet unload name manager          - Shut down the node
"""


def main(argv: list[str]) -> int:
    """Run the program; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    rest = names.parse_arguments(argv[1:]).rest
    # roslaunch adds arguments at the end, so nodelet's own arguments come first.
    remaps = [arg for arg in argv[1:] if arg not in rest]
    words = [arg for arg in rest if arg != "--no-bond"]
    try:
        check_arguments(words)
    except NodeletError as error:
        sys.stderr.write(f"{USAGE}ERROR: nodelet: {error}\n")
        return 1
    verb = words[0]
    if verb == "manager":
        from pyros1.robot_nodes.nodelet.manager import main as run_manager  # noqa: PLC0415 - not for `load`

        return run_manager([argv[0], *remaps])
    if verb == "unload":
        return _dispatch("node", "kill", words[1])
    try:
        package, program = locate_nodelet(words[1], PackageIndex(os.environ).executables)
    except NodeletError as error:
        if is_throttle(words[1]):
            from pyros1.robot_nodes.nodelet.throttle import main as run_throttle  # noqa: PLC0415 - not for others

            return run_throttle([argv[0], *words[1 + len(OPERANDS[verb]) :], *remaps])
        sys.stderr.write(f"ERROR: nodelet: {error}\n")
        return 1
    return _dispatch("run", package, program, *words[1 + len(OPERANDS[verb]) :], *remaps)


def _dispatch(*words: str) -> int:
    from pyros1.cli.dispatch import dispatch  # noqa: PLC0415 - not for `manager`

    return dispatch(["pyros1", *words], alone=True)
