"""The arguments of launch files."""

from __future__ import annotations

from typing import Any

from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.world import make_resources
from roslaunch.core import rl_errors


@rl_errors
def get_args(roslaunch_files: Any) -> dict[str, tuple[str | None, str | None]]:
    """Return documentation and default of each argument, by name; None for what there is not.

    Raises:
        RLException: a file cannot be read.
    """
    plan = load_plan(list(roslaunch_files), {}, make_resources(), only_args=True)
    return {arg.name: (arg.doc, arg.default) for arg in plan.args.values()}
