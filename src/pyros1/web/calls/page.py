"""The call that returns information for the page itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pyros1
from pyros1.web.robot import Robot


def about(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Return the server's version, its master's URI, any problem, and whether the server is read-only.

    Pages call this repeatedly.
    """
    return {
        "version": pyros1.__version__,
        "master": robot.master_uri,
        "trouble": robot.problem or robot.master_problem(),
        "read_only": robot.access.read_only,
    }


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"about": about}
CHANGES: frozenset[str] = frozenset()
