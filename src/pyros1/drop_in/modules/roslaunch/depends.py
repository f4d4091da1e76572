"""The command roslaunch-deps, which prints what launch files depend on."""

from __future__ import annotations

import sys

from pyros1.drop_in.commands import main as _main
from pyros1.drop_in.module_attributes import module_getattr

NAME = "roslaunch-deps"
_ALTERNATIVE = "see `pyros1 launch --deps`"


class RoslaunchDepsException(Exception):
    """A launch file cannot be read."""


def roslaunch_deps_main(argv: list[str] = sys.argv) -> None:
    """Run the command; exit with its exit code if it fails."""
    _main("roslaunch", [argv[0], "--deps", *argv[1:]])


__getattr__ = module_getattr(
    "roslaunch.depends",
    RoslaunchDeps=_ALTERNATIVE,
    calculate_missing=_ALTERNATIVE,
    parse_launch=_ALTERNATIVE,
    print_deps=_ALTERNATIVE,
    rl_file_deps=_ALTERNATIVE,
    roslaunch_deps=_ALTERNATIVE,
)
