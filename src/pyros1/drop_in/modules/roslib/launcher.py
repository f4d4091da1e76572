"""Start of Python programs of ROS packages."""

from __future__ import annotations

import os
import sys

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import PackageNotFoundError


def load_manifest(package_name: str) -> None:
    """Let the Python modules of a package be imported; nothing to do for packages without any."""
    try:
        folder = PackageIndex(os.environ).find_folder(package_name)
    except PackageNotFoundError:
        return
    for name in ("src", "lib"):
        path = os.path.join(folder, name)
        if os.path.isdir(path) and path not in sys.path:
            sys.path.append(path)
