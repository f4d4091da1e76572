"""File names, and the exception for packages that do not exist."""

from __future__ import annotations

from collections.abc import Sequence

from pyros1.drop_in.module_attributes import module_getattr

MANIFEST_FILE = "manifest.xml"
PACKAGE_FILE = "package.xml"
STACK_FILE = "stack.xml"
ROS_STACK = "ros"

__getattr__ = module_getattr(__name__)


class ResourceNotFound(Exception):
    """The package or stack does not exist.

    Args:
        msg: name of the package or stack.
        ros_paths: the folders that were searched.
    """

    def __init__(self, msg: str, ros_paths: Sequence[str] | None = None) -> None:
        super().__init__(msg)
        self.ros_paths = ros_paths

    def __str__(self) -> str:
        lines = [str(self.args[0]), *(f"ROS path [{n}]={path}" for n, path in enumerate(self.ros_paths or ()))]
        return "\n".join(lines)
