"""The 3D panel's call, which converts rviz files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.names import SEP, canonicalize_name
from pyros1.web.robot import Robot
from pyros1.web.scene.rviz.file import read_rviz
from pyros1.web.views.view import string_arg


def rviz(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Convert an rviz file to the panel's ``settings``, and ``notes``: lines for the user. Args: text (the file's)."""
    rviz_file = read_rviz(string_arg(args, "text"), lambda name: canonicalize_name(SEP + name))
    return {"settings": rviz_file.settings, "notes": rviz_file.notes}


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"rviz": rviz}
CHANGES: frozenset[str] = frozenset()
