"""Packages and their files; this module is older than rospkg."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

from rospkg import ResourceNotFound, RosPack, get_package_name
from rospkg.common import MANIFEST_FILE, PACKAGE_FILE
from rospkg.environment import ROS_PACKAGE_PATH, ROS_ROOT

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.finding.packages import files_below

_REASON = "use rospkg.list_by_path"
__getattr__ = module_getattr(__name__, list_pkgs_by_path=_REASON, list_pkgs=_REASON)


class ROSPkgException(Exception):
    """An operation on a package failed."""


class InvalidROSPkgException(ROSPkgException):
    """There is no such package."""


def get_pkg_dir(
    package: str, required: bool = True, ros_root: str | None = None, ros_package_path: str | None = None
) -> str | None:
    """Return the folder of a package.

    Args:
        package: the name of the package.
        required: whether to raise an error if the package does not exist; otherwise None is returned.
        ros_root, ros_package_path: where to search; None for the values in the environment.

    Raises:
        InvalidROSPkgException: there is no such package.
    """
    paths = None
    if ros_root is not None or ros_package_path is not None:
        all_paths = [ros_root or "", *(ros_package_path or os.environ.get(ROS_PACKAGE_PATH, "")).split(os.pathsep)]
        paths = [path for path in all_paths if path]
    try:
        return RosPack.get_instance(paths).get_path(package)
    except ResourceNotFound:
        if not required:
            return None
        root, path = os.environ.get(ROS_ROOT), os.environ.get(ROS_PACKAGE_PATH)
        raise InvalidROSPkgException(
            f"Cannot locate installation of package {package}. ROS_ROOT[{root}] ROS_PACKAGE_PATH[{path}]"
        ) from None


def get_dir_pkg(d: str) -> tuple[str | None, str | None]:
    """Return folder and name of the package that contains a folder; (None, None) if it is in no package."""
    folder = os.path.realpath(d)
    while True:
        if any(os.path.isfile(os.path.join(folder, name)) for name in (PACKAGE_FILE, MANIFEST_FILE)):
            return folder, get_package_name(folder)
        if folder == os.path.dirname(folder):
            return None, None
        folder = os.path.dirname(folder)


def get_pkg_subdir(
    package: str, subdir: str, required: bool = True, env: Mapping[str, str] | None = None
) -> str | None:
    """Return a folder in a package; it is created if it is required but missing. Raises InvalidROSPkgException."""
    folder = get_pkg_dir(package, required)
    if folder is None:
        return None
    path = os.path.join(folder, subdir)
    if required and not os.path.isdir(path):
        try:
            os.makedirs(path)
        except OSError as error:
            raise ROSPkgException(f"Package '{package}' has no folder '{subdir}': {error}") from error
    return path


def resource_file(package: str, subdir: str, resource_name: str) -> str:
    """Return the path of a file in a folder of a package; raises InvalidROSPkgException."""
    folder = get_pkg_subdir(package, subdir, False)
    if folder is None:
        raise InvalidROSPkgException(package)
    return os.path.join(folder, resource_name)


def find_node(pkg: str, node_type: str, rospack: Any = None) -> list[str]:
    """Return the paths of all executables in a package that have a given name.

    Args:
        pkg: the package.
        node_type: the name.
        rospack: finds the packages; None for the packages in the environment.

    Raises:
        rospkg.ResourceNotFound: there is no such package.
    """
    from pyros1.finding.packages import PackageIndex

    paths = (RosPack.get_instance() if rospack is None else rospack).get_ros_paths()
    environ = {**os.environ, "ROS_PACKAGE_PATH": os.pathsep.join(paths)}
    try:
        return [str(path) for path in PackageIndex(environ).find_executable(pkg, node_type)]
    except LookupError:
        raise ResourceNotFound(pkg, ros_paths=paths) from None


def find_resource(
    pkg: str, resource_name: str, filter_fn: Callable[[str], bool] | None = None, rospack: Any = None
) -> list[str]:
    """Return the paths of all files in a package that have a given name.

    Args:
        pkg: the package.
        resource_name: the file's name, or a path relative to the package.
        filter_fn: called with each path; returns whether to include it. None to include all paths.
        rospack: finds the packages; None for the packages in the environment.

    Raises:
        rospkg.ResourceNotFound: there is no such package.
    """
    folder = (RosPack.get_instance() if rospack is None else rospack).get_path(pkg)
    return _find_resource(folder, resource_name, filter_fn)


def _find_resource(d: str, resource_name: str, filter_fn: Callable[[str], bool] | None = None) -> list[str]:
    direct_path = os.path.join(d, resource_name)
    if os.path.dirname(resource_name):
        paths = [direct_path] if os.path.isfile(direct_path) else []
    else:
        paths = [os.path.join(base, resource_name) for base, files in files_below(d) if resource_name in files]
    return [path for path in paths if filter_fn is None or filter_fn(path)]
