"""Where ROS packages are on this machine (https://wiki.ros.org/ROS/EnvironmentVariables#ROS_PACKAGE_PATH).

A package is a folder with a ``package.xml`` (catkin) or a ``manifest.xml`` (rosbuild). Searched are, in this order: the
folders of ``ROS_PACKAGE_PATH`` with everything below them, the devel and install spaces of ``CMAKE_PREFIX_PATH``, stock
installations found on the machine, the Python packages of this interpreter that declare a ROS package (by a
``package.xml`` in their folder, or by installing ``share/NAME/package.xml``), and the packages that come with pyros1.
Of several packages of one name below one of these folders the first in the order of the folders' names counts, as
rospack has it. Nothing is read before a question is asked, and what was found is remembered by the object: have one of
them and ask it everything.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from pyros1.errors import PackageNotFoundError

OWN_PACKAGES = Path(__file__).resolve().parent.parent / "packages"
"""Folder of the ROS packages that are part of pyros1."""

_COMMENT = re.compile("<!--.*?-->", re.DOTALL)
_NAME_TAG = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
_IGNORE_MARKS = frozenset({"CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs"})
MAX_DEPTH = 20
"""How many levels below a folder of ``ROS_PACKAGE_PATH`` packages are looked for."""
_Names = list[str]
_Paths = list[Path]


def stock_installs() -> list[Path]:
    """Return the ``share`` folders of stock installations: those of ``/opt/ros`` (newest name first), then Debian's."""
    found = sorted(Path("/opt/ros").glob("*/share"), reverse=True)
    return [*found, Path("/usr/share")]


def share_folders(environ: Mapping[str, str]) -> list[Path]:
    """Return the ``share`` folders of the spaces of ``CMAKE_PREFIX_PATH`` and of stock installations, in order."""
    return list(dict.fromkeys([*(prefix / "share" for prefix in _prefixes(environ)), *stock_installs()]))


def _prefixes(environ: Mapping[str, str]) -> _Paths:
    return [Path(part) for part in environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if part]


def _python_folders() -> _Paths:
    """Where Python's installers put packages, and the data files that belong to them."""
    libraries = [Path(part) for part in sys.path if os.path.basename(part) in ("site-packages", "dist-packages")]
    return [Path(sys.prefix, "share"), *libraries]


class PackageIndex:
    """Finds packages and files in them.

    Args:
        environ: environment variables; ``ROS_PACKAGE_PATH`` and ``CMAKE_PREFIX_PATH`` are used.
        installs: folders of packages to search behind ``ROS_PACKAGE_PATH``; None means those of this machine.
        own: folder of pyros1's own packages.
    """

    def __init__(
        self, environ: Mapping[str, str], *, installs: Sequence[Path] | None = None, own: Path = OWN_PACKAGES
    ) -> None:
        self._roots = [Path(part) for part in environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
        self._prefixes = _prefixes(environ)
        found = [*share_folders(environ), *_python_folders()] if installs is None else installs
        self._flat = list(dict.fromkeys([*found, own]))
        self._own = own
        self._found: dict[str, Path] = {}
        self._crawled: dict[Path, dict[str, Path]] = {}
        self._executables: dict[tuple[str, str], _Paths] = {}

    def places(self) -> list[tuple[Path, int]]:
        """Return the folders searched, in order, each with how many levels deep."""
        return [*((root, MAX_DEPTH) for root in self._roots), *((share, 1) for share in self._flat)]

    def find(self, name: str) -> Path:
        """Return the folder of the package.

        Raises:
            PackageNotFoundError: it is in none of the places; the text names them.
        """
        path = self._found.get(name)
        if path is None:
            path = self._search(name)
            if path is None:
                places = ", ".join(dict.fromkeys(str(place) for place, _ in self.places()))
                raise PackageNotFoundError(
                    f"package [{name}] not found (searched: {places}); is ROS_PACKAGE_PATH set as it should be?"
                )
            self._found[name] = path
        return path

    def paths(self) -> dict[str, Path]:
        """Return every package's folder by name; where a name occurs twice, the place searched first wins."""
        result: dict[str, Path] = {}
        for root in self._roots:
            for name, path in self._crawl(root).items():
                result.setdefault(name, path)
        for share in self._flat:
            for folder in _subfolders(share):
                name_found = _package_name(folder)
                if name_found is not None:
                    result.setdefault(name_found, folder)
        return result

    def find_resource(self, package: str, filename: str) -> _Paths:
        """Return the files of that name in a package.

        Args:
            package: package name.
            filename: a plain name, searched everywhere in the package, or a path relative to the package's folder.

        Returns:
            Paths in the order found, each file once; empty if there is none.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find(package)
        if os.path.dirname(filename):
            path = folder / filename
            return [path] if path.is_file() else []
        return _unique(path for path in _walk(folder, filename) if path.is_file())

    def find_executable(self, package: str, name: str) -> _Paths:
        """Return the executables of that name: first in ``lib/<package>`` of an install prefix, then in the package.

        Args:
            package: package name.
            name: file name, or a path relative to the package's folder; in pyros1's own packages ``name.py`` too.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find(package)
        known = self._executables.get((package, name))
        if known and all(path.is_file() for path in known):
            return list(known)
        found = self._executables_in(folder, package, name)
        # Debian installs some packages without their programs, which are in packages of their own.
        spare = self._own / package
        if not found and spare != folder and _package_name(spare) == package:
            found = self._executables_in(spare, package, name)
        self._executables[package, name] = found
        return list(found)

    def _executables_in(self, folder: Path, package: str, name: str) -> _Paths:
        own = self._own in folder.parents
        prefixes = list(self._prefixes)
        if folder.parent.name == "share":
            prefixes.append(folder.parent.parent)
        candidates = [prefix / "lib" / package / name for prefix in prefixes]
        if os.path.dirname(name):
            candidates.append(folder / name)
        else:
            candidates.extend(_walk(folder, name))
            if own and not name.endswith(".py"):
                candidates.extend(_walk(folder, name + ".py"))
        # Installers may drop the executable bit of a package's data files; ours are started through their interpreter.
        return _unique(path for path in candidates if path.is_file() and (own or os.access(path, os.X_OK)))

    def executables(self, package: str) -> _Names:
        """Return the names of everything in a package that can be started, sorted.

        Args:
            package: package name.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        folder = self.find(package)
        prefixes = [*self._prefixes, *([folder.parent.parent] if folder.parent.name == "share" else [])]
        names: set[str] = set()
        for place in [*(prefix / "lib" / package for prefix in prefixes), folder]:
            for base, folders, files in os.walk(place):
                folders[:] = [name for name in folders if name[0] != "."]
                names.update(name for name in files if os.access(os.path.join(base, name), os.X_OK))
        if self._own in folder.parents:
            names.update(path.stem for path in folder.rglob("*.py"))
        return sorted(names)

    def _search(self, name: str) -> Path | None:
        if not name or "/" in name or name.startswith("."):
            return None
        for root in self._roots:
            below = self._crawl(root).get(name)
            if below is not None:
                return below
        for share in self._flat:
            if _package_name(share / name) == name:
                return share / name
        return None

    def _crawl(self, root: Path) -> dict[str, Path]:
        found = self._crawled.get(root)
        if found is None:
            found = {}
            for folder in _packages_below(root):
                name = _package_name(folder)
                if name is not None:
                    found.setdefault(name, folder)
            self._crawled[root] = found  # when it is complete: other threads may ask, too
        return found

    def list(self) -> _Names:
        """Return the names of all packages, sorted."""
        return sorted(self.paths())


def _package_name(folder: Path) -> str | None:
    """Return the name of the package that ``folder`` is, None if it is none."""
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return folder.name if (folder / "manifest.xml").is_file() else None
    match = _NAME_TAG.search(_COMMENT.sub("", text))
    return match[1] if match else folder.name


def package_of(file: Path) -> tuple[Path, str]:
    """Return folder and name of the package that a file belongs to, or of its own folder if that is in no package."""
    path = file.resolve()
    for folder in path.parents:
        name = _package_name(folder)
        if name is not None:
            return folder, name
    return path.parent, path.parent.name


def _subfolders(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            return sorted(Path(entry.path) for entry in entries if entry.name[0] != "." and entry.is_dir())
    except OSError:
        return []


def _packages_below(root: Path, depth: int = 0, above: tuple[tuple[int, int], ...] = ()) -> Iterator[Path]:
    """Yield package folders in order; packages do not nest, marked folders and links that lead back are passed over.

    ``above`` has device and inode of the folders on the way.
    """
    try:
        status = os.stat(root)
        here = (status.st_dev, status.st_ino)
        if here in above:
            return
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
    for name in sorted(names):
        if name[0] != "." and entries[name].is_dir():
            yield from _packages_below(root / name, depth + 1, (*above, here))


def _walk(folder: Path, filename: str) -> Iterator[Path]:
    for base, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if name[0] != ".")
        if filename in files:
            yield Path(base, filename)


def _unique(paths: Iterator[Path]) -> list[Path]:
    result: dict[Path, Path] = {}
    for path in paths:
        result.setdefault(path.resolve(), path)
    return list(result.values())
