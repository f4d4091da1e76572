"""Makes the Python modules of ROS packages importable; this module is older than rospkg."""

from __future__ import annotations

import os
import sys
from typing import Any

from rospkg import ResourceNotFound, RosPack

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)


def load_manifest(package_name: str, bootstrap_version: str = "0.7") -> None:
    """Make the Python modules of a package and its dependencies importable.

    The import hook finds modules of packages anyway, so a missing package is not an error.

    Args:
        package_name: the package.
        bootstrap_version: has no effect.
    """
    rospack = RosPack.get_instance()
    for name in (package_name, *_dependencies(package_name, rospack)):
        try:
            folder = rospack.get_path(name)
        except ResourceNotFound:
            continue
        for subfolder in ("src", "lib"):
            path = os.path.join(folder, subfolder)
            if os.path.isdir(path) and path not in sys.path:
                sys.path.append(path)


def _dependencies(package: str, rospack: Any) -> list[str]:
    try:
        dependencies: list[str] = rospack.get_depends(package)
    except Exception:  # noqa: BLE001  a package's broken manifest must not stop a program
        return []
    return dependencies
