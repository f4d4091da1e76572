"""Finds the ROS packages on this machine (https://wiki.ros.org/ROS/EnvironmentVariables#ROS_PACKAGE_PATH).

A package is a folder with a ``package.xml`` (catkin) or a ``manifest.xml`` (rosbuild). The following are searched, in
this order: the folders of ``ROS_PACKAGE_PATH`` with everything below them, the devel and install spaces of
``CMAKE_PREFIX_PATH``, stock installations on the machine, the Python packages of this interpreter that declare a ROS
package (with a ``package.xml`` in their folder, or by installing ``share/NAME/package.xml``), and the packages that
come with pyros1. If several packages below one of these folders have the same name, the one directly in that folder, in
a subfolder of the package's name, is used, or else the first one in the order of folder names. (Stock ROS uses the file
system's order.) Nothing is read before it is needed, and the index caches its results, so one index should be used
for all searches.

Every node searches for the packages of its messages when it starts. So a package in its usual location is found without
searching all others, and this module handles paths as strings: `pathlib` is only imported by methods that return its
objects.
"""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from pyros1.ground.errors import PackageNotFoundError

if TYPE_CHECKING:
    from pathlib import Path

    _Paths = list[Path]

OWN_PACKAGES = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "packages")
"""Folder of the ROS packages that come with pyros1."""

# Compiled when first needed; most nodes never need it.
_COMMENT_PATTERN = "(?s)<!--.*?-->"
_NAME_TAG_PATTERN = r"<name\s*>\s*([^<\s]+)\s*</name\s*>"
_MAX_MANIFEST_SIZE = 1 << 20
"""Maximum number of characters of a package.xml that are read to find the package's name."""
_IGNORE_MARKERS = frozenset({"CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs"})
MAX_CRAWL_DEPTH = 20
"""Number of levels that are searched for packages below a folder of ``ROS_PACKAGE_PATH``."""
_StrList = list[str]


def stock_installs() -> _StrList:
    """Return the ``share`` folders of stock installations: those in ``/opt/ros``, in reverse order of names, then
    Debian's.
    """
    found = [f"/opt/ros/{name}/share" for name in reversed(_list_folder("/opt/ros"))]
    return [*filter(os.path.isdir, found), "/usr/share"]


def share_folders(environ: Mapping[str, str]) -> _StrList:
    """Return the ``share`` folders of the prefixes in ``CMAKE_PREFIX_PATH`` and of stock installations, in order."""
    return list(dict.fromkeys([*(os.path.join(prefix, "share") for prefix in _prefixes(environ)), *stock_installs()]))


def _prefixes(environ: Mapping[str, str]) -> _StrList:
    return _normalize_all(environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep))


def _normalize_all(folders: Iterable[str]) -> _StrList:
    """Return the non-empty paths, without redundant slashes and dots."""
    result = []
    for folder in filter(None, folders):
        path = "/".join(part for part in folder.split("/") if part not in ("", "."))
        result.append(f"/{path}" if folder[0] == "/" else path or ".")
    return result


def _python_folders() -> _StrList:
    """Return the folders of installed Python packages and of their data files."""
    libraries = [part for part in sys.path if os.path.basename(part) in ("site-packages", "dist-packages")]
    return [os.path.join(sys.prefix, "share"), *libraries]


def _to_paths(folders: Iterable[str]) -> list[Path]:
    from pathlib import Path  # noqa: PLC0415 - see above

    return list(map(Path, folders))


class PackageIndex:
    """An index of packages and the files in them.

    Args:
        environ: environment variables; ``ROS_PACKAGE_PATH`` and ``CMAKE_PREFIX_PATH`` are used.
        installs: folders of packages to search after ``ROS_PACKAGE_PATH``; None for the installations on this machine.
        own: folder of the packages that come with pyros1.
    """

    def __init__(
        self,
        environ: Mapping[str, str],
        *,
        installs: Sequence[str | os.PathLike[str]] | None = None,
        own: str | os.PathLike[str] = OWN_PACKAGES,
    ) -> None:
        self._roots = _normalize_all(environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep))
        self._prefixes = _prefixes(environ)
        flat_folders = [*share_folders(environ), *_python_folders()] if installs is None else installs
        self._own = os.fspath(own)
        self._flat_folders = list(dict.fromkeys(os.fspath(folder) for folder in (*flat_folders, self._own)))
        self._found_folders: dict[str, str] = {}
        self._crawled: dict[str, dict[str, str]] = {}
        self._executables: dict[tuple[str, str], _StrList] = {}

    def search_folders(self) -> list[tuple[str, int]]:
        """Return the folders to search, in order, each with the number of levels."""
        depths = [MAX_CRAWL_DEPTH] * len(self._roots) + [1] * len(self._flat_folders)
        return list(zip([*self._roots, *self._flat_folders], depths, strict=True))

    def find(self, name: str) -> Path:
        """Return the folder of the package.

        Raises:
            PackageNotFoundError: there is no such package; the message names the folders that were searched.
        """
        return _to_paths([self.find_folder(name)])[0]

    def find_folder(self, name: str) -> str:
        """Return the path of the package's folder; raises the same errors as `find`."""
        folder = self._found_folders.get(name)
        if folder is None:
            folder = self._search(name)
            if folder is None:
                search_folders = ", ".join(dict.fromkeys([*self._roots, *self._flat_folders]))
                raise PackageNotFoundError(
                    f"package [{name}] not found (searched: {search_folders}); is ROS_PACKAGE_PATH set correctly?"
                )
            self._found_folders[name] = folder
        return folder

    def paths(self) -> dict[str, Path]:
        """Return package name -> folder of all packages; of several packages with one name, the first is used."""
        result: dict[str, str] = {}
        for root in self._roots:
            for name, folder in self._crawl(root).items():
                result.setdefault(name, folder)
        for share in self._flat_folders:
            for base in _list_folder(share):
                folder = os.path.join(share, base)
                found_name = _package_name(folder) if base[0] != "." else None
                if found_name is not None:
                    result.setdefault(found_name, folder)
        return dict(zip(result, _to_paths(result.values()), strict=True))

    def packages_below_roots(self) -> _StrList:
        """Return the folders of all packages below the folders of ``ROS_PACKAGE_PATH``."""
        return list(dict.fromkeys(folder for root in self._roots for folder in self._crawl(root).values()))

    def find_resource(self, package: str, filename: str) -> _Paths:
        """Return the paths of the files with a given name in a package.

        Args:
            package: package name.
            filename: a plain name, which is searched in the whole package, or a path relative to the package's folder.

        Returns:
            The paths in the order found, each file once; empty if no file matches.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find_folder(package)
        if os.path.dirname(filename):
            path = os.path.join(folder, filename)
            return _to_paths([path] if os.path.isfile(path) else [])
        return _to_paths(_without_duplicates(filter(os.path.isfile, _find_files(folder, filename))))

    def find_executable(self, package: str, name: str) -> _Paths:
        """Return the paths of executables with a given name: first those in ``lib/<package>`` of an install prefix,
        then those in the package.

        Args:
            package: package name.
            name: file name, or path relative to the package's folder. In packages that come with pyros1, the file may
                also be ``name.py``.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find_folder(package)
        cached = self._executables.get((package, name))
        if cached and all(map(os.path.isfile, cached)):
            return _to_paths(cached)
        found = self._find_executables(folder, package, name)
        # Debian installs the programs of some ROS packages in separate Debian packages.
        own_folder = os.path.join(self._own, package)
        if not found and own_folder != folder and _package_name(own_folder) == package:
            found = self._find_executables(own_folder, package, name)
        self._executables[package, name] = found
        return _to_paths(found)

    def _is_own(self, folder: str) -> bool:
        return folder.startswith(self._own + os.sep)

    def _library_folders(self, folder: str, package: str) -> _StrList:
        """Return the folders ``lib/<package>`` that may contain the programs of a package."""
        prefixes = list(self._prefixes)
        share = os.path.dirname(folder)
        if os.path.basename(share) == "share":
            prefixes.append(os.path.dirname(share))
        return [os.path.join(prefix, "lib", package) for prefix in prefixes]

    def _find_executables(self, folder: str, package: str, name: str) -> _StrList:
        is_own = self._is_own(folder)
        candidates = [os.path.join(library, name) for library in self._library_folders(folder, package)]
        if os.path.dirname(name):
            candidates.append(os.path.join(folder, name))
        else:
            candidates.extend(_find_files(folder, name))
            if is_own and not name.endswith(".py"):
                candidates.extend(_find_files(folder, name + ".py"))
        # Installers may clear the executable bit of data files; our own programs are started with their interpreter.
        return _without_duplicates(
            path for path in candidates if os.path.isfile(path) and (is_own or os.access(path, os.X_OK))
        )

    def executables(self, package: str) -> _StrList:
        """Return the names of all executables in a package, sorted.

        Args:
            package: package name.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find_folder(package)
        is_own = self._is_own(folder)
        names: set[str] = set()
        for base_folder in [*self._library_folders(folder, package), folder]:
            for base, files in files_below(base_folder):
                names.update(name for name in files if os.access(os.path.join(base, name), os.X_OK))
                if is_own:
                    names.update(name[:-3] for name in files if name.endswith(".py"))
        return sorted(names)

    def _search(self, name: str) -> str | None:
        if not name or "/" in name or name.startswith("."):
            return None
        for root in self._roots:
            if is_direct(root, name):
                return os.path.join(root, name)
            folder = self._crawl(root).get(name)
            if folder is not None:
                return folder
        for share in self._flat_folders:
            folder = os.path.join(share, name)
            if _package_name(folder) == name:
                return folder
        return None

    def _crawl(self, root: str) -> dict[str, str]:
        found = self._crawled.get(root)
        if found is None:
            found = {}
            for folder in _packages_below(root, set()):
                name = _package_name(folder)
                if name is not None and (name not in found or folder == os.path.join(root, name)):
                    found[name] = folder
            self._crawled[root] = found  # stored when complete, since other threads may read it
        return found

    def list(self) -> _StrList:
        """Return the names of all packages, sorted."""
        return sorted(self.paths())


def is_direct(root: str, name: str) -> bool:
    """Return whether a folder of ``ROS_PACKAGE_PATH`` directly contains a package, in a subfolder of the same name."""
    folder = os.path.join(root, name)
    if _package_name(folder) != name or os.path.exists(os.path.join(folder, "CATKIN_IGNORE")):
        return False
    return not any(
        os.path.exists(os.path.join(root, marker)) for marker in (*_IGNORE_MARKERS, "package.xml", "manifest.xml")
    )


def manifest_text(path: str) -> str:
    """Return the start of a manifest's text; empty if it is not a regular file, since reading a device, for example,
    might never end.

    Raises:
        OSError: the file cannot be read.
        ValueError: the path is not a legal file name; for example, it contains a NUL character.
    """
    with open(path, encoding="utf-8", errors="replace", opener=_open_nonblocking) as file:
        return file.read(_MAX_MANIFEST_SIZE) if stat.S_ISREG(os.fstat(file.fileno()).st_mode) else ""


def _open_nonblocking(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))  # a pipe without a writer would block


def _package_name(folder: str) -> str | None:
    """Return the name of the package in ``folder``, or None if it is not a package."""
    try:
        text = manifest_text(os.path.join(folder, "package.xml"))
    except (OSError, ValueError):  # ValueError: a name from a bag or a peer may not be a possible file name
        return os.path.basename(folder) if os.path.isfile(os.path.join(folder, "manifest.xml")) else None
    return package_name_in(strip_comments(text)) or os.path.basename(folder)


def strip_comments(text: str) -> str:
    """Return a manifest's text without comments."""
    return re.sub(_COMMENT_PATTERN, "", text)


def package_name_in(text: str) -> str:
    """Return the package name in a manifest's text without comments, or an empty string if there is none."""
    match = re.search(_NAME_TAG_PATTERN, text)
    return match[1] if match else ""


def enclosing_package(file: Path) -> tuple[Path, str]:
    """Return the path and name of the package that contains a file, or of the file's folder if no package does."""
    path = file.resolve()
    for folder in path.parents:
        name = _package_name(str(folder))
        if name is not None:
            return folder, name
    return path.parent, path.parent.name


def _list_folder(folder: str) -> _StrList:
    """Return the names in a folder, sorted; empty if the folder cannot be read."""
    try:
        return sorted(os.listdir(folder))
    except OSError:
        return []


def _packages_below(
    root: str, visited: set[tuple[int, int]], depth: int = 0, ancestors: tuple[tuple[int, int], ...] = ()
) -> Iterator[str]:
    """Yield package folders in order. Packages do not nest; folders with ignore markers and circular links are skipped.

    ``ancestors`` contains (device, inode) of each parent folder, ``visited`` those of each visited folder; links to
    these folders are skipped.
    """
    try:
        status = os.stat(root)
        folder_id = (status.st_dev, status.st_ino)
        if folder_id in ancestors or (folder_id in visited and os.path.islink(root)):
            return
        visited.add(folder_id)
        with os.scandir(root) as listing:
            entries = {entry.name: entry for entry in listing}
    except OSError:
        return
    names = entries.keys()
    if "package.xml" in names or "manifest.xml" in names:
        if "CATKIN_IGNORE" not in names:
            yield root
        return
    if depth >= MAX_CRAWL_DEPTH or not _IGNORE_MARKERS.isdisjoint(names):
        return
    for name in sorted(name for name, entry in entries.items() if name[0] != "." and is_folder(entry)):
        yield from _packages_below(os.path.join(root, name), visited, depth + 1, (*ancestors, folder_id))


def files_below(folder: str) -> Iterator[tuple[str, _StrList]]:
    """Yield a folder and the folders below it, each with the names of its files, in order; hidden folders are skipped.

    As in stock ROS, links to folders are followed after everything that is reached without them. Each folder is visited
    once, and the parents of `folder` are never visited, so circular links are harmless.
    """
    visited = {_device_and_inode(parent) for parent in _parents(os.path.realpath(folder))}
    start_folders = [folder]
    for start in start_folders:  # grows during iteration
        pending = [start]
        while pending:
            base = pending.pop()
            try:
                folder_id = _device_and_inode(base)
                with os.scandir(base) as listing:
                    entries = sorted(listing, key=lambda entry: entry.name)
            except OSError:
                continue
            if folder_id in visited:
                continue
            visited.add(folder_id)
            folder_names = {entry.name for entry in entries if is_folder(entry)}
            yield base, [entry.name for entry in entries if entry.name not in folder_names]
            subfolders = [entry for entry in entries if entry.name in folder_names and entry.name[0] != "."]
            start_folders += [entry.path for entry in subfolders if entry.is_symlink()]
            pending += [entry.path for entry in reversed(subfolders) if not entry.is_symlink()]


def is_folder(entry: os.DirEntry[str]) -> bool:
    """Return whether an entry is a folder or a link to one; False for circular links, where is_dir() raises OSError."""
    try:
        return entry.is_dir()
    except OSError:
        return False


def _device_and_inode(folder: str) -> tuple[int, int]:
    status = os.stat(folder)
    return status.st_dev, status.st_ino


def _parents(folder: str) -> Iterator[str]:
    while folder != os.path.dirname(folder):
        folder = os.path.dirname(folder)
        yield folder


def _find_files(folder: str, filename: str) -> Iterator[str]:
    for base, files in files_below(folder):
        if filename in files:
            yield os.path.join(base, filename)


def _without_duplicates(paths: Iterable[str]) -> _StrList:
    result: dict[str, str] = {}
    for path in paths:
        result.setdefault(os.path.realpath(path), path)
    return list(result.values())
