"""The ROS 2 types whose definitions are on this machine, in packages of an installation or a workspace."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from pyros1.ground.errors import DefinitionError, Error
from pyros1.ros2_types.definitions import MAX_TEXT_LENGTH, PARTS, full_type_name, parse_types
from pyros1.ros2_types.model import MessageType

MAX_FOLDERS = 20_000
"""Maximum number of folders that are searched."""
_MAX_DEPTH = 8
_SKIPPED = frozenset(["build", "log", "node_modules"])
_PACKAGE_NAME = re.compile(r"<name>\s*([A-Za-z][A-Za-z0-9_]*)\s*</name>")
_MAX_MANIFEST = 1 << 16


class PackagesError(Error, ValueError):
    """A folder with ROS 2 packages cannot be used."""


class InstalledTypes(Mapping[str, MessageType]):
    """Types by full name: messages, and the parts of services and actions. Files are read on demand.

    Args:
        folders: folders with ROS 2 packages, up to 8 levels deep: a workspace's ``src`` or ``install``, or
            ``/opt/ros/jazzy``.

    Raises:
        PackagesError: a folder does not exist, contains no definitions, or contains too many folders.
    """

    def __init__(self, folders: Iterable[str | os.PathLike[str]] = ()) -> None:
        self._files: dict[str, Path] = {}
        self._read: dict[Path, dict[str, MessageType]] = {}
        for folder in folders:
            found = dict(_definitions(Path(folder)))
            if not found:
                raise PackagesError(f"{folder}: there are no packages with .msg, .srv or .action files here")
            self._files = found | self._files  # the first folder counts, as with AMENT_PREFIX_PATH

    def __getitem__(self, name: str) -> MessageType:
        path = self._files[name]
        if path not in self._read:
            self._read[path] = _parse(name, path)
        if name not in self._read[path]:
            raise DefinitionError(f"[{name}] is not defined here", str(path))
        return self._read[path][name]

    def __contains__(self, name: object) -> bool:
        return name in self._files

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)


def environment_folders(environ: Mapping[str, str]) -> list[Path]:
    """Return the ``share`` folders of a sourced ROS 2 installation that exist and contain definitions."""
    folders = [Path(each, "share") for each in environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if each]
    return [folder for folder in folders if any(folder.glob("*/msg/*.msg")) or any(folder.glob("*/srv/*.srv"))]


def _definitions(top: Path) -> Iterator[tuple[str, Path]]:
    """Yield the names of types and the files with their definitions."""
    if not top.is_dir():
        raise PackagesError(f"{top}: there is no such folder")
    count = 0
    for place, folders, files in os.walk(top):
        count += 1
        if count > MAX_FOLDERS:
            raise PackagesError(f"{top}: it has more than {MAX_FOLDERS} folders; name the folders of the packages")
        path = Path(place)
        depth = len(path.relative_to(top).parts)
        folders[:] = sorted(
            name for name in folders if depth < _MAX_DEPTH and name not in _SKIPPED and not name.startswith(".")
        )
        if "package.xml" in files:  # a package contains no other packages, but many folders
            folders[:] = [name for name in folders if name in PARTS]
        kind = path.name
        if kind not in PARTS:
            continue
        package = _package_name(path.parent)
        for file in sorted(files):
            stem, _, ending = file.rpartition(".")
            try:
                name = full_type_name(f"{package}/{kind}/{stem}") if ending == kind else ""
            except DefinitionError:
                continue  # not a ROS 2 definition
            for part in PARTS[kind] if name else ():
                yield name + part, path / file


def _package_name(folder: Path) -> str:
    """Return the package name in a package's manifest, or else its folder's name."""
    try:
        with open(folder / "package.xml", encoding="utf-8", errors="replace") as file:
            match = _PACKAGE_NAME.search(file.read(_MAX_MANIFEST))
    except OSError:
        match = None
    return match[1] if match else folder.resolve().name


def _parse(name: str, path: Path) -> dict[str, MessageType]:
    package, kind, _ = name.split("/")
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return parse_types(f"{package}/{kind}/{path.stem}", file.read(MAX_TEXT_LENGTH + 1))
    except OSError as error:
        raise DefinitionError(f"cannot be read: {error}", str(path)) from None
