"""Finds the folders that contain log files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from pyros1.launch.running.logs import log_folder, ros_home


def existing_log_folders() -> Iterator[tuple[Path, str]]:
    """Yield each log folder that exists, with links resolved, and its label."""
    for folder, label in (
        (log_folder(os.environ), "ROS node logs"),
        (ros_home(os.environ) / "rosmake", "rosmake logs"),
    ):
        if folder.is_dir():
            yield folder.resolve() if folder.is_symlink() else folder, label
