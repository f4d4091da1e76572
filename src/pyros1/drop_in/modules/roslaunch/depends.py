"""What launch files depend on."""

from __future__ import annotations

from typing import Any


class RoslaunchDepsException(Exception):
    """A launch file cannot be read."""


def __getattr__(name: str) -> Any:
    if name in ("RoslaunchDeps", "roslaunch_deps", "rl_file_deps", "calculate_missing", "print_deps", "parse_launch"):
        raise AttributeError(f"pyros1 has no roslaunch.depends.{name}: see the command roslaunch-deps")
    raise AttributeError(f"module 'roslaunch.depends' has no attribute {name!r}")
