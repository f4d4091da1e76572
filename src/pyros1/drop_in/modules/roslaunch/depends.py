"""What launch files depend on."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.missing import missing


class RoslaunchDepsException(Exception):
    """A launch file cannot be read."""


__getattr__ = missing(
    "roslaunch.depends",
    RoslaunchDeps="see the command roslaunch-deps",
    roslaunch_deps="see the command roslaunch-deps",
    rl_file_deps="see the command roslaunch-deps",
    calculate_missing="see the command roslaunch-deps",
    print_deps="see the command roslaunch-deps",
    parse_launch="see the command roslaunch-deps",
)
