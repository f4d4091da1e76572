"""Finds the ROS packages of this machine (https://wiki.ros.org/ROS/EnvironmentVariables#ROS_PACKAGE_PATH).

A package is a folder with a ``package.xml`` (catkin) or a ``manifest.xml`` (rosbuild). The search goes, in this order,
through the folders of ``ROS_PACKAGE_PATH`` with everything below them, the devel and install spaces of
``CMAKE_PREFIX_PATH``, stock installations on the machine, the Python packages of this interpreter that declare a ROS
package (by a ``package.xml`` in their folder, or by installing ``share/NAME/package.xml``), and the packages that come
with pyros1. If one of these folders holds several packages of the same name, the one directly in it counts, if its
folder has that name, else the first in the order of the folders' names. (Stock takes the order in which the file
system lists them.) Nothing is read before it is needed, and the index remembers what it has found: use one index for
all searches.

Every node looks for the packages of its messages when it starts. So a package in its usual place is found without a
search through all others, and this module handles paths as strings: `pathlib` is loaded only by methods that return
its objects.
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
"""Folder of the ROS packages that are part of pyros1."""

# Compiled when needed, which most nodes never do.
_COMMENT = "(?s)<!--.*?-->"
_NAME_TAG = r"<name\s*>\s*([^<\s]+)\s*</name\s*>"
_MAX_MANIFEST_SIZE = 1 << 20
"""Maximum number of characters of a package.xml that are read to find the name."""
_IGNORE_MARKS = frozenset({"CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs"})
MAX_DEPTH = 20
"""Number of levels below a folder of ``ROS_PACKAGE_PATH`` that are searched for packages."""
_Names = list[str]


def stock_installs() -> _Names:
    """Return the ``share`` folders of stock installations: those of ``/opt/ros`` (newest name first), then Debian's."""
    found = [f"/opt/ros/{name}/share" for name in reversed(_listed("/opt/ros"))]
    return [*filter(os.path.isdir, found), "/usr/share"]


def share_folders(environ: Mapping[str, str]) -> _Names:
    """Return the ``share`` folders of the spaces of ``CMAKE_PREFIX_PATH`` and of stock installations, in order."""
    return list(dict.fromkeys([*(os.path.join(prefix, "share") for prefix in _prefixes(environ)), *stock_installs()]))


def _prefixes(environ: Mapping[str, str]) -> _Names:
    return _normalized(environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep))


def _normalized(folders: Iterable[str]) -> _Names:
    """Return the paths that are not empty, without needless slashes and dots."""
    result = []
    for folder in filter(None, folders):
        path = "/".join(part for part in folder.split("/") if part not in ("", "."))
        result.append(f"/{path}" if folder[0] == "/" else path or ".")
    return result


def _python_folders() -> _Names:
    """Return the folders of installed Python packages, and of the data files that belong to them."""
    libraries = [part for part in sys.path if os.path.basename(part) in ("site-packages", "dist-packages")]
    return [os.path.join(sys.prefix, "share"), *libraries]


def _paths(folders: Iterable[str]) -> list[Path]:
    from pathlib import Path  # noqa: PLC0415 - see above

    return list(map(Path, folders))


class PackageIndex:
    """Index of packages and of files in them.

    Args:
        environ: environment variables; ``ROS_PACKAGE_PATH`` and ``CMAKE_PREFIX_PATH`` are used.
        installs: folders of packages to search after ``ROS_PACKAGE_PATH``; None means those of this machine.
        own: folder of pyros1's own packages.
    """

    def __init__(
        self,
        environ: Mapping[str, str],
        *,
        installs: Sequence[str | os.PathLike[str]] | None = None,
        own: str | os.PathLike[str] = OWN_PACKAGES,
    ) -> None:
        self._roots = _normalized(environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep))
        self._prefixes = _prefixes(environ)
        flat = [*share_folders(environ), *_python_folders()] if installs is None else installs
        self._own = os.fspath(own)
        self._flat = list(dict.fromkeys(os.fspath(folder) for folder in (*flat, self._own)))
        self._found: dict[str, str] = {}
        self._crawled: dict[str, dict[str, str]] = {}
        self._executables: dict[tuple[str, str], _Names] = {}

    def search_folders(self) -> list[tuple[str, int]]:
        """Return the folders to search, in order, each with the number of levels."""
        depths = [MAX_DEPTH] * len(self._roots) + [1] * len(self._flat)
        return list(zip([*self._roots, *self._flat], depths, strict=True))

    def find(self, name: str) -> Path:
        """Return the folder of the package.

        Raises:
            PackageNotFoundError: there is no such package; the message names the folders that were searched.
        """
        return _paths([self.find_folder(name)])[0]

    def find_folder(self, name: str) -> str:
        """Return the path of the package's folder; raises as `find`."""
        folder = self._found.get(name)
        if folder is None:
            folder = self._search(name)
            if folder is None:
                search_folders = ", ".join(dict.fromkeys([*self._roots, *self._flat]))
                raise PackageNotFoundError(
                    f"package [{name}] not found (searched: {search_folders}); is ROS_PACKAGE_PATH set correctly?"
                )
            self._found[name] = folder
        return folder

    def paths(self) -> dict[str, Path]:
        """Return the folders of all packages (name -> path); of several packages with one name the first counts."""
        result: dict[str, str] = {}
        for root in self._roots:
            for name, folder in self._crawl(root).items():
                result.setdefault(name, folder)
        for share in self._flat:
            for base in _listed(share):
                folder = os.path.join(share, base)
                name_found = _package_name(folder) if base[0] != "." else None
                if name_found is not None:
                    result.setdefault(name_found, folder)
        return dict(zip(result, _paths(result.values()), strict=True))

    def below_roots(self) -> _Names:
        """Return the folders of all packages below the folders of ``ROS_PACKAGE_PATH``."""
        return list(dict.fromkeys(folder for root in self._roots for folder in self._crawl(root).values()))

    def find_resource(self, package: str, filename: str) -> _Paths:
        """Return the paths of the files of that name in a package.

        Args:
            package: package name.
            filename: a plain name, searched everywhere in the package, or a path relative to the package's folder.

        Returns:
            Paths in the order found, each file once; empty if no file matches.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find_folder(package)
        if os.path.dirname(filename):
            path = os.path.join(folder, filename)
            return _paths([path] if os.path.isfile(path) else [])
        return _paths(_without_duplicates(filter(os.path.isfile, _walk(folder, filename))))

    def find_executable(self, package: str, name: str) -> _Paths:
        """Return the paths of executables: first those in ``lib/<package>`` of an install prefix, then in the package.

        Args:
            package: package name.
            name: file name, or a path relative to the package's folder; in pyros1's own packages also ``name.py``.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find_folder(package)
        known = self._executables.get((package, name))
        if known and all(map(os.path.isfile, known)):
            return _paths(known)
        found = self._executables_in(folder, package, name)
        # Debian installs the programs of some packages with separate packages.
        own_folder = os.path.join(self._own, package)
        if not found and own_folder != folder and _package_name(own_folder) == package:
            found = self._executables_in(own_folder, package, name)
        self._executables[package, name] = found
        return _paths(found)

    def _is_own(self, folder: str) -> bool:
        return folder.startswith(self._own + os.sep)

    def _libraries(self, folder: str, package: str) -> _Names:
        """Return the folders ``lib/<package>`` in which a package may have programs."""
        prefixes = list(self._prefixes)
        share = os.path.dirname(folder)
        if os.path.basename(share) == "share":
            prefixes.append(os.path.dirname(share))
        return [os.path.join(prefix, "lib", package) for prefix in prefixes]

    def _executables_in(self, folder: str, package: str, name: str) -> _Names:
        own = self._is_own(folder)
        candidates = [os.path.join(library, name) for library in self._libraries(folder, package)]
        if os.path.dirname(name):
            candidates.append(os.path.join(folder, name))
        else:
            candidates.extend(_walk(folder, name))
            if own and not name.endswith(".py"):
                candidates.extend(_walk(folder, name + ".py"))
        # Installers may drop the executable bit of a package's data files; ours are started through their interpreter.
        return _without_duplicates(
            path for path in candidates if os.path.isfile(path) and (own or os.access(path, os.X_OK))
        )

    def executables(self, package: str) -> _Names:
        """Return the names of all executables of a package, sorted.

        Args:
            package: package name.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find_folder(package)
        own = self._is_own(folder)
        names: set[str] = set()
        for base_folder in [*self._libraries(folder, package), folder]:
            for base, files in files_below(base_folder):
                names.update(name for name in files if os.access(os.path.join(base, name), os.X_OK))
                if own:
                    names.update(name[:-3] for name in files if name.endswith(".py"))
        return sorted(names)

    def _search(self, name: str) -> str | None:
        if not name or "/" in name or name.startswith("."):
            return None
        for root in self._roots:
            if is_direct(root, name):
                return os.path.join(root, name)
            below = self._crawl(root).get(name)
            if below is not None:
                return below
        for share in self._flat:
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
            self._crawled[root] = found  # only when it is complete: other threads may read it as well
        return found

    def list(self) -> _Names:
        """Return the names of all packages, sorted."""
        return sorted(self.paths())


def is_direct(root: str, name: str) -> bool:
    """Return whether a folder of ``ROS_PACKAGE_PATH`` holds that package directly, in a folder of its name."""
    folder = os.path.join(root, name)
    if _package_name(folder) != name or os.path.exists(os.path.join(folder, "CATKIN_IGNORE")):
        return False
    return not any(os.path.exists(os.path.join(root, mark)) for mark in (*_IGNORE_MARKS, "package.xml", "manifest.xml"))


def manifest_text(path: str) -> str:
    """Return a manifest's text; empty if it is not a regular file: a device, for example, may never end.

    Raises:
        OSError: it cannot be read.
        ValueError: the path is not possible as a file name.
    """
    with open(path, encoding="utf-8", errors="replace", opener=_open_nonblocking) as file:
        return file.read(_MAX_MANIFEST_SIZE) if stat.S_ISREG(os.fstat(file.fileno()).st_mode) else ""


def _open_nonblocking(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))  # a pipe without a writer would block


def _package_name(folder: str) -> str | None:
    """Return the name of the package in ``folder``, None if it is not a package."""
    try:
        text = manifest_text(os.path.join(folder, "package.xml"))
    except (OSError, ValueError):  # ValueError: bags and peers may send names that no file can have
        return os.path.basename(folder) if os.path.isfile(os.path.join(folder, "manifest.xml")) else None
    return package_name_in(strip_comments(text)) or os.path.basename(folder)


def strip_comments(text: str) -> str:
    """Return a manifest's text without comments."""
    return re.sub(_COMMENT, "", text)


def package_name_in(text: str) -> str:
    """Return the package name in a manifest's text without comments; empty if it has none."""
    match = re.search(_NAME_TAG, text)
    return match[1] if match else ""


def package_of(file: Path) -> tuple[Path, str]:
    """Return path and name of the package that holds a file, or of the file's own folder if no package holds it."""
    path = file.resolve()
    for folder in path.parents:
        name = _package_name(str(folder))
        if name is not None:
            return folder, name
    return path.parent, path.parent.name


def _listed(folder: str) -> _Names:
    """Return the names in a folder, sorted; nothing if it cannot be read."""
    try:
        return sorted(os.listdir(folder))
    except OSError:
        return []


def _packages_below(
    root: str, seen: set[tuple[int, int]], depth: int = 0, ancestors: tuple[tuple[int, int], ...] = ()
) -> Iterator[str]:
    """Yield package folders in order; packages do not nest; marked folders and circular links are skipped.

    ``ancestors`` holds device and inode of the folders on the way, ``seen`` those of all folders so far: links to them
    are skipped.
    """
    try:
        status = os.stat(root)
        here = (status.st_dev, status.st_ino)
        if here in ancestors or (here in seen and os.path.islink(root)):
            return
        seen.add(here)
        with os.scandir(root) as listing:
            entries = {entry.name: entry for entry in listing}
    except OSError:
        return
    names = entries.keys()
    if "package.xml" in names or "manifest.xml" in names:
        if "CATKIN_IGNORE" not in names:
            yield root
        return
    if depth >= MAX_DEPTH or not _IGNORE_MARKS.isdisjoint(names):
        return
    for name in sorted(name for name, entry in entries.items() if name[0] != "." and is_folder(entry)):
        yield from _packages_below(os.path.join(root, name), seen, depth + 1, (*ancestors, here))


def files_below(folder: str) -> Iterator[tuple[str, _Names]]:
    """Yield a folder and those below, each with the names of its files, in order; hidden folders are skipped.

    Links to folders are followed, as in stock, after everything that is reached without them. Each folder is
    entered once, and the parents of `folder` never, so circular links do no harm.
    """
    seen = {_identity(parent) for parent in _parents(os.path.realpath(folder))}
    behind = [folder]
    for start in behind:  # it grows
        waiting = [start]
        while waiting:
            base = waiting.pop()
            try:
                here = _identity(base)
                with os.scandir(base) as listing:
                    entries = sorted(listing, key=lambda entry: entry.name)
            except OSError:
                continue
            if here in seen:
                continue
            seen.add(here)
            below = {entry.name for entry in entries if is_folder(entry)}
            yield base, [entry.name for entry in entries if entry.name not in below]
            inside = [entry for entry in entries if entry.name in below and entry.name[0] != "."]
            behind += [entry.path for entry in inside if entry.is_symlink()]
            waiting += [entry.path for entry in reversed(inside) if not entry.is_symlink()]


def is_folder(entry: os.DirEntry[str]) -> bool:
    """Return whether an entry of a folder is a folder or a link to one (is_dir() raises OSError for circular links)."""
    try:
        return entry.is_dir()
    except OSError:
        return False


def _identity(folder: str) -> tuple[int, int]:
    status = os.stat(folder)
    return status.st_dev, status.st_ino


def _parents(folder: str) -> Iterator[str]:
    while folder != os.path.dirname(folder):
        folder = os.path.dirname(folder)
        yield folder


def _walk(folder: str, filename: str) -> Iterator[str]:
    for base, files in files_below(folder):
        if filename in files:
            yield os.path.join(base, filename)


def _without_duplicates(paths: Iterable[str]) -> _Names:
    result: dict[str, str] = {}
    for path in paths:
        result.setdefault(os.path.realpath(path), path)
    return list(result.values())
