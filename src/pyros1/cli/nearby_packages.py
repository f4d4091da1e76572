"""Finds packages near the current folder, so that users need not set ``ROS_PACKAGE_PATH``.

If the current folder contains packages, they are the nearby packages. Otherwise, the current folder and its parents are
searched. If a package is found first, the nearby packages are that package and its siblings. If a workspace is found
first, they are the packages in its ``src``.

Nearby packages are appended to ``ROS_PACKAGE_PATH``, so that packages in the user's setting have priority. Nodes that
are started inherit the variable, and find the same packages whatever their current folder is.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, MutableMapping
from itertools import islice

_MANIFESTS = ("package.xml", "manifest.xml")
_WORKSPACE_MARKERS = (".catkin_workspace", ".catkin_tools", "devel", "src/CMakeLists.txt")
_MAX_ENTRIES = 5000
"""Maximum number of entries of a folder that are examined."""


def add_nearby_packages(environ: MutableMapping[str, str]) -> None:
    """Append the packages near the current folder to ``ROS_PACKAGE_PATH``.

    Args:
        environ: the environment variables, which are changed.
    """
    try:
        current_folder = os.getcwd()
    except OSError:  # the folder was removed
        return
    configured_folders = [part for part in environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
    nearby_folders = find_nearby_packages(current_folder)
    if not nearby_folders:
        return
    from pyros1.finding.packages import OWN_PACKAGES  # noqa: PLC0415 - not needed by most commands

    # pyros1's own packages have the lowest priority; appending one of them to the variable would raise its priority.
    covered_folders = (*configured_folders, OWN_PACKAGES)
    new_folders = [folder for folder in nearby_folders if not any(_is_inside(folder, root) for root in covered_folders)]
    if new_folders and os.pathsep not in "".join(new_folders):
        environ["ROS_PACKAGE_PATH"] = os.pathsep.join([*configured_folders, *new_folders])


def find_nearby_packages(start_folder: str) -> list[str]:
    """Return the folders of the packages near a folder. In a workspace, return the folder that contains all of them."""
    folders = list(_packages_in(start_folder))
    folder = start_folder
    while not folders:
        if _is_package(folder):
            folders = list(_packages_in(os.path.dirname(folder)))
        else:
            source_folder = os.path.join(folder, "src")
            if os.path.isdir(source_folder):
                is_workspace = any(os.path.exists(os.path.join(folder, marker)) for marker in _WORKSPACE_MARKERS)
                folders = (
                    [source_folder]
                    if is_workspace and _is_trusted(source_folder, folder)
                    else list(_packages_in(source_folder))
                )
        parent = os.path.dirname(folder)
        if parent == folder:
            break
        folder = parent
    return folders


def _packages_in(folder: str) -> Iterator[str]:
    try:
        with os.scandir(folder) as entries:
            subfolders = (entry for entry in islice(entries, _MAX_ENTRIES) if entry.name[0] != ".")
            names = sorted(entry.name for entry in subfolders if not entry.is_file(follow_symlinks=False))
    except OSError:
        return
    for name in names:
        path = os.path.join(folder, name)
        if _is_package(path) and _is_trusted(path, folder):
            yield path


def _is_package(folder: str) -> bool:
    return any(os.path.isfile(os.path.join(folder, name)) for name in _MANIFESTS)


def _is_trusted(folder: str, parent: str) -> bool:
    """Return whether to use a folder. In world-writable folders such as /tmp, only the user's own folders are used."""
    if not hasattr(os, "getuid"):
        return True  # this system has no world-writable folders
    return not os.stat(parent).st_mode & 0o002 or os.stat(folder).st_uid == os.getuid()


def _is_inside(folder: str, root: str) -> bool:
    return folder == root or folder.startswith(root.rstrip(os.sep) + os.sep)
