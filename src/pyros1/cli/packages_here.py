"""Packages around the current folder, which are found without any setting.

These are the packages in the current folder; inside a package, it and those next to it; inside a workspace, those in
its ``src``. They are appended to ``ROS_PACKAGE_PATH``, so that the user's setting has priority and started nodes find
them wherever they run.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, MutableMapping
from itertools import islice

_MANIFESTS = ("package.xml", "manifest.xml")
_WORKSPACE_MARKS = (".catkin_workspace", ".catkin_tools", "devel", "src/CMakeLists.txt")
_MAX_ENTRIES = 5000


def add_packages_here(environ: MutableMapping[str, str]) -> None:
    """Append the packages around the current folder to ``ROS_PACKAGE_PATH``.

    Args:
        environ: environment variables; changed.
    """
    try:
        start = os.getcwd()
    except OSError:  # it was removed
        return
    known = [part for part in environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
    around = packages_around(start)
    if not around:
        return
    from pyros1.finding.packages import OWN_PACKAGES  # noqa: PLC0415 - most commands need no packages

    known_or_last = (*known, OWN_PACKAGES)  # the shipped ones stay last, even if the current folder is in them
    found = [folder for folder in around if not any(_is_in(folder, root) for root in known_or_last)]
    if found and os.pathsep not in "".join(found):
        environ["ROS_PACKAGE_PATH"] = os.pathsep.join([*known, *found])


def packages_around(start: str) -> list[str]:
    """Return the folders of the packages around a folder, or the folder in which all of them are."""
    found = list(_packages_in(start))
    folder = start
    while not found:
        if _is_package(folder):
            found = list(_packages_in(os.path.dirname(folder)))
        else:
            source = os.path.join(folder, "src")
            if os.path.isdir(source):
                marked = any(os.path.exists(os.path.join(folder, mark)) for mark in _WORKSPACE_MARKS)
                found = [source] if marked and _may_trust(source, folder) else list(_packages_in(source))
        parent = os.path.dirname(folder)
        if parent == folder:
            break
        folder = parent
    return found


def _packages_in(folder: str) -> Iterator[str]:
    try:
        with os.scandir(folder) as entries:
            subfolders = (entry for entry in islice(entries, _MAX_ENTRIES) if entry.name[0] != ".")
            names = sorted(entry.name for entry in subfolders if not entry.is_file(follow_symlinks=False))
    except OSError:
        return
    for name in names:
        path = os.path.join(folder, name)
        if _is_package(path) and _may_trust(path, folder):
            yield path


def _is_package(folder: str) -> bool:
    return any(os.path.isfile(os.path.join(folder, name)) for name in _MANIFESTS)


def _may_trust(folder: str, parent: str) -> bool:
    """Return whether to use a folder: in places where anybody can create folders, such as /tmp, only the user's own."""
    if not hasattr(os, "getuid"):
        return True  # this system has no such places
    return not os.stat(parent).st_mode & 0o002 or os.stat(folder).st_uid == os.getuid()


def _is_in(folder: str, root: str) -> bool:
    return folder == root or folder.startswith(root.rstrip(os.sep) + os.sep)
