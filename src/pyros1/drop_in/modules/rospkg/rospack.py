"""Finds the packages on this machine and their dependencies."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from pyros1.drop_in.module_attributes import class_getattr, module_getattr
from pyros1.finding.packages import PackageIndex, enclosing_package
from rospkg.common import MANIFEST_FILE, PACKAGE_FILE, STACK_FILE, ResourceNotFound
from rospkg.environment import get_ros_paths
from rospkg.manifest import InvalidManifest, Manifest, parse_manifest_file

_REASON = "`pip install rospkg` provides it"
__getattr__ = module_getattr(__name__, expand_to_packages=_REASON, get_stack_version_by_dir=_REASON)


class ManifestManager:
    """The packages or stacks in some folders.

    Args:
        manifest_name: file name of the manifests.
        ros_paths: the folders; None for the environment's and all others in which pyros1 searches.
    """

    _instances: dict[Any, Any] = {}

    def __init__(self, manifest_name: str, ros_paths: Sequence[str] | None = None) -> None:
        self._manifest_name = manifest_name
        self._has_own_paths = ros_paths is not None
        self._ros_paths = get_ros_paths() if ros_paths is None else list(ros_paths)
        self._folders: dict[str, str] | None = None
        self._manifests: dict[str, Manifest] = {}
        self._dependencies: dict[str, list[str]] = {}
        self._custom: dict[Any, Any] = {}

    @classmethod
    def get_instance(cls, ros_paths: Sequence[str] | None = None) -> Any:
        """Return the shared instance for these folders."""
        key = (cls, tuple(get_ros_paths() if ros_paths is None else ros_paths))
        instance = ManifestManager._instances.get(key)
        if instance is None:
            instance = ManifestManager._instances[key] = cls(ros_paths=ros_paths)  # type: ignore[call-arg]
        return instance

    def get_ros_paths(self) -> list[str]:
        """Return the folders that are searched."""
        return list(self._ros_paths)

    ros_paths = property(get_ros_paths)

    def _folders_by_name(self) -> dict[str, str]:
        if self._folders is None:
            self._folders = self._find_folders()
        return self._folders

    def _find_folders(self) -> dict[str, str]:
        raise NotImplementedError

    def list(self) -> Any:
        """Return the names of all packages or stacks."""
        return self._folders_by_name().keys()

    def get_path(self, name: str) -> str:
        """Return the folder of a package or stack; raises ResourceNotFound if there is none."""
        folder = self._folders_by_name().get(name)
        if folder is None:
            raise ResourceNotFound(name, ros_paths=self._ros_paths)
        return folder

    def get_manifest(self, name: str) -> Manifest:
        """Return the manifest of a package or stack; raises ResourceNotFound, or InvalidManifest."""
        if name not in self._manifests:
            self._manifests[name] = parse_manifest_file(self.get_path(name), self._manifest_name, self)
        return self._manifests[name]

    def get_depends(self, name: str, implicit: bool = True) -> Any:
        """Return the names of the dependencies of a package or stack.

        Args:
            name: the name of the package or stack.
            implicit: whether to include indirect dependencies.

        Raises:
            ResourceNotFound: the package or stack, or one of its dependencies, does not exist.
        """
        direct_names = [dependency.name for dependency in self.get_manifest(name).depends]
        if not implicit:
            return direct_names
        if name not in self._dependencies:
            all_names: dict[str, None] = {}
            pending = direct_names[::-1]
            while pending:
                dependency_name = pending.pop()
                if dependency_name not in all_names and dependency_name != name:
                    all_names[dependency_name] = None
                    pending += [dependency.name for dependency in self.get_manifest(dependency_name).depends]
            self._dependencies[name] = list(all_names)
        return self._dependencies[name]

    def get_depends_on(self, name: str, implicit: bool = True) -> Any:
        """Return the names of the packages or stacks that depend on this one; broken ones are left out.

        See :meth:`get_depends` for the arguments.
        """
        dependent_names = []
        for other_name in self.list():
            try:
                if name in self.get_depends(other_name, implicit):
                    dependent_names.append(other_name)
            except (ResourceNotFound, InvalidManifest, OSError):
                continue
        return dependent_names

    def get_custom_cache(self, key: Any, default: Any = None) -> Any:
        """Return data that a program has stored with `set_custom_cache`."""
        return self._custom.get(key, default)

    def set_custom_cache(self, key: Any, value: Any) -> None:
        """Store data for `get_custom_cache`."""
        self._custom[key] = value


class RosPack(ManifestManager):
    """The packages in the folders ``ros_paths``; None for all packages that pyros1 finds."""

    def __init__(self, ros_paths: Sequence[str] | None = None) -> None:
        super().__init__(MANIFEST_FILE, ros_paths)
        self._index = package_index(self._ros_paths if self._has_own_paths else None)

    def _find_folders(self) -> dict[str, str]:
        paths = {name: str(path) for name, path in self._index.paths().items()}
        return {name: path for name, path in paths.items() if not is_metapackage(path)}

    def get_path(self, name: str) -> str:
        """Return the folder of a package; raises ResourceNotFound if there is none."""
        folder = ""
        if isinstance(name, str):
            with suppress(LookupError):
                folder = self._index.find_folder(name)  # without searching all packages
        if not folder or is_metapackage(folder):
            raise ResourceNotFound(name, ros_paths=self._ros_paths)
        return folder

    def get_rosdeps(self, package: str, implicit: bool = True) -> Any:
        """Return the names of the system packages on which a package depends; see :meth:`get_depends`."""
        names = [package, *(self.get_depends(package) if implicit else ())]
        return list(dict.fromkeys(rosdep.name for name in names for rosdep in self.get_manifest(name).rosdeps))

    def stack_of(self, package: str) -> None:
        """Return None: only rosbuild's packages were in stacks. Raises ResourceNotFound if there is no such package."""
        self.get_path(package)


class RosStack(ManifestManager):
    """The metapackages in the folders ``ros_paths``; None for all metapackages that pyros1 finds."""

    def __init__(self, ros_paths: Sequence[str] | None = None) -> None:
        super().__init__(STACK_FILE, ros_paths)

    __getattr__ = class_getattr("RosStack", _REASON, frozenset({"get_stack_version"}))

    def _find_folders(self) -> dict[str, str]:
        paths = package_index(self._ros_paths if self._has_own_paths else None).paths()
        return {name: str(path) for name, path in paths.items() if is_metapackage(str(path))}

    def packages_of(self, stack: str) -> list[str]:
        """Return an empty list: a metapackage's packages are its dependencies. Raises ResourceNotFound."""
        self.get_path(stack)
        return []


def package_index(paths: Sequence[str] | None) -> PackageIndex:
    """Return an index of the packages in some folders; None for all that pyros1 finds."""
    if paths is None:
        return PackageIndex(os.environ)
    return PackageIndex({"ROS_PACKAGE_PATH": os.pathsep.join(paths)}, installs=[], own=os.devnull)


def list_by_path(manifest_name: str, path: str, cache: dict[str, str]) -> Any:
    """Return the names of the packages or stacks below a folder, and add their folders to ``cache``.

    Packages with a package.xml are found whatever ``manifest_name`` is; metapackages are found as stacks.
    """
    names = []
    for folder, subfolders, files in os.walk(os.path.abspath(path), followlinks=False):
        if "rospack_nosubdirs" in files or "CATKIN_IGNORE" in files:
            subfolders.clear()
            if "CATKIN_IGNORE" in files:
                continue
        if PACKAGE_FILE in files:
            name = package_of_folder(folder)
            subfolders.clear()
            kinds = {PACKAGE_FILE, STACK_FILE if is_metapackage(folder) else MANIFEST_FILE}
            if manifest_name not in kinds:
                continue
        elif manifest_name in files:
            name = os.path.basename(folder)
            subfolders.clear()
        else:
            subfolders[:] = sorted(subfolder for subfolder in subfolders if subfolder[0] != ".")
            continue
        names.append(name)
        cache[name] = folder
    return names


def package_of_folder(folder: str) -> str:
    """Return the name of the package in a folder."""
    from pathlib import Path

    return enclosing_package(Path(folder, PACKAGE_FILE))[1]


def get_package_name(path: str) -> str | None:
    """Return the name of the package that contains a path; None if there is none."""
    folder = os.path.realpath(path)
    while True:
        for name in (PACKAGE_FILE, MANIFEST_FILE):
            if os.path.isfile(os.path.join(folder, name)):
                return package_of_folder(folder) if name == PACKAGE_FILE else os.path.basename(folder)
        if folder == os.path.dirname(folder):
            return None
        folder = os.path.dirname(folder)


def is_metapackage(folder: str) -> bool:
    """Return whether a folder contains the package.xml of a metapackage, which is considered a stack."""
    try:
        with open(os.path.join(folder, PACKAGE_FILE), encoding="utf-8", errors="replace") as file:
            return re.search(r"<metapackage\s*/?>", file.read(1 << 20)) is not None
    except OSError:
        return False
