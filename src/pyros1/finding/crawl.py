"""Finds all packages on this machine by crawling folders; the results are cached between commands.

The records of a crawl contain the modification time and the content of each folder. A later command only checks the
times, and reads the folders that have changed, so additions, moves and removals are noticed immediately. Folders that
have just changed are not recorded, since a second change within the clock's resolution would not be noticed.
"""

from __future__ import annotations

import contextlib
import json
import os
import time
from binascii import crc32
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pyros1.finding.packages import PackageIndex, manifest_text, package_name_in, strip_comments

MANIFEST_NAMES = ("package.xml", "manifest.xml", "stack.xml")
_IGNORE_MARKERS = frozenset({"CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs"})
_VERSION = 1
_MIN_TRUSTED_AGE = 2_000_000_000  # ns; some file systems store times in steps of two seconds

# Record of a folder: [its mtime, names of its subfolders, file name of its manifest, that file's mtime, package name,
# whether it is a metapackage]
Record = list[Any]


class FoundPackage(NamedTuple):
    """A package on this machine.

    Attributes:
        name: the package's name.
        folder: path of the package's folder.
        manifest: file name of its manifest: ``package.xml``, ``manifest.xml`` or, for a rosbuild stack, ``stack.xml``.
        is_meta: whether it is a metapackage.
    """

    name: str
    folder: str
    manifest: str
    is_meta: bool

    @property
    def is_catkin(self) -> bool:
        """Whether it is a catkin package rather than a rosbuild package."""
        return self.manifest == "package.xml"


def search_folders(environ: Mapping[str, str]) -> list[tuple[str, int]]:
    """Return the folders to search for packages, in order, each with the number of levels to search."""
    return [(_normalize(folder), depth) for folder, depth in PackageIndex(environ).search_folders()]


def _normalize(folder: str) -> str:
    """Normalise a path as ``pathlib`` does. That module is not used, since importing it takes a large part of a short
    command's time.
    """
    steps = "/".join(part for part in folder.split("/") if part not in ("", "."))
    return f"/{steps}" if folder.startswith("/") else steps or "."


def cache_folder(environ: Mapping[str, str]) -> str:
    """Return the cache folder: ``$XDG_CACHE_HOME/pyros1`` or ``~/.cache/pyros1``."""
    base = environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return os.path.join(base, "pyros1")


def all_packages(environ: Mapping[str, str], *, roots: list[tuple[str, int]] | None = None) -> list[FoundPackage]:
    """Return all packages in search order; of several packages with the same name, the first takes precedence.

    If several packages below one root have the same name, the one that is directly in the root, in a folder of that
    name, comes first, as in `PackageIndex`.

    Args:
        environ: environment variables, which determine where to search and where the cache is.
        roots: the folders to search, each with the number of levels; None for the default ones.
    """
    roots = search_folders(environ) if roots is None else roots
    file = _record_file(environ, roots)
    crawl = Crawl(_load_records(file))
    found: dict[str, FoundPackage] = {}
    for root, depth in roots:
        packages = list(crawl.packages(root, depth))
        direct_names = {package.name for package in packages if _is_direct(package, root)}
        for package in sorted(
            packages, key=lambda package: package.name in direct_names and not _is_direct(package, root)
        ):
            found.setdefault(package.folder, package)
    if crawl.has_changed:
        _save_records(file, crawl.trusted_records())
    return list(found.values())


def find_cached(environ: Mapping[str, str], name: str) -> FoundPackage | None:
    """Return a package from the records of an earlier crawl, without checking all other packages.

    Only the package itself and the folders outside of packages are checked for changes.

    Args:
        environ: environment variables, which determine where to search and where the cache is.
        name: the package's name.

    Returns:
        The package; None if a full crawl (:func:`all_packages`) is needed, because something has changed or there is no
        such package.
    """
    roots = search_folders(environ)
    records = _load_records(_record_file(environ, roots))
    try:
        for root, depth in roots:
            found = list(_cached_packages(records, root, depth, name))
            if found:
                return next((package for package in found if _is_direct(package, root)), found[0])
    except (LookupError, OSError):
        pass
    return None


def _is_direct(package: FoundPackage, root: str) -> bool:
    return package.folder == f"{root.rstrip('/')}/{package.name}"


def _cached_packages(records: Mapping[str, Record], folder: str, depth: int, name: str) -> Iterator[FoundPackage]:
    """Yield the packages with the given name in a folder and below, according to the records.

    Raises:
        LookupError: a record is missing or outdated.
        OSError: a recorded folder no longer exists or cannot be accessed.
    """
    record = records.get(folder)
    if record is None:
        if os.path.isdir(folder):
            raise LookupError
        return
    mtime, folders, manifest, manifest_mtime, package, is_meta = record
    if not manifest or package == name:
        if os.stat(folder).st_mtime_ns != mtime or (
            manifest and _modification_time(folder, manifest) != manifest_mtime
        ):
            raise LookupError
        if manifest:
            yield FoundPackage(package, folder, manifest, is_meta)
    if depth > 0:
        for subfolder in folders:
            path = f"{folder.rstrip('/')}/{subfolder}"
            sub_record = records.get(path)
            if (
                sub_record is None or not sub_record[2] or sub_record[4] == name or sub_record[1]
            ):  # otherwise the folder is another package
                yield from _cached_packages(records, path, depth - 1, name)


def _record_file(environ: Mapping[str, str], roots: list[tuple[str, int]]) -> str:
    # If two sets of roots had the same checksum, they would share a file, which is harmless.
    return os.path.join(cache_folder(environ), f"packages-{crc32(repr(roots).encode()):08x}.json")


class Crawl:
    """A search through folders that uses the records of an earlier search.

    Args:
        records: folder -> record.
        now: the current time in nanoseconds; None to use the clock.

    Attributes:
        has_changed: whether any folder has changed since its record was made, or had no record.
    """

    def __init__(self, records: Mapping[str, Record], now: int | None = None) -> None:
        self._old_records = records
        self._new_records: dict[str, Record] = {}
        # Folders visited below the current root; links to them are not followed.
        self._visited: set[tuple[int, int]] = set()
        self._now = time.time_ns() if now is None else now
        self.has_changed = False

    def packages(self, folder: str, depth: int, ancestors: tuple[tuple[int, int], ...] = ()) -> Iterator[FoundPackage]:
        """Yield the packages in a folder and below, sorted by name.

        Args:
            folder: the folder to search.
            depth: number of levels to search.
            ancestors: (device, inode) of each parent folder, so that links back to them are not followed.
        """
        try:
            status = os.stat(folder)
        except OSError:
            return
        if not ancestors:
            self._visited.clear()
        folder_id = (status.st_dev, status.st_ino)
        if folder_id in ancestors or (folder_id in self._visited and os.path.islink(folder)):
            return
        self._visited.add(folder_id)
        record = self._current_record(folder, status.st_mtime_ns)
        if record is None:
            return
        _, folders, manifest, _, name, is_meta = record
        if manifest:
            yield FoundPackage(name, folder, manifest, is_meta)
        if depth > 0:
            for subfolder in folders:
                yield from self.packages(f"{folder.rstrip('/')}/{subfolder}", depth - 1, (*ancestors, folder_id))

    def trusted_records(self) -> dict[str, Record]:
        """Return the records that a later crawl can trust: the records of folders that have not just changed."""
        newest_trusted = self._now - _MIN_TRUSTED_AGE
        return {
            folder: record for folder, record in self._new_records.items() if max(record[0], record[3]) < newest_trusted
        }

    def _current_record(self, folder: str, mtime: int) -> Record | None:
        record = self._old_records.get(folder)
        if record is None or record[0] != mtime or (record[2] and _modification_time(folder, record[2]) != record[3]):
            try:
                record = _read_folder(folder, mtime)
            except OSError:
                return None
            self.has_changed = True
        self._new_records[folder] = record
        return record


def measure_folders(roots: list[tuple[str, int]]) -> list[tuple[float, str, bool]]:
    """Measure how long it takes to read each folder and everything below it, without records; slowest first.

    Args:
        roots: the folders to search, each with the number of levels.

    Returns:
        For each folder that is not itself a package, (seconds, folder, whether a folder below is a package).
    """
    timings: list[tuple[float, str, bool]] = []

    visited: set[str] = set()

    def measure(folder: str, depth: int) -> bool:
        start = time.perf_counter()
        real_path = os.path.realpath(folder)
        if real_path in visited:
            return True
        visited.add(real_path)
        try:
            record = _read_folder(folder, 0)
        except OSError:
            return False
        child_results = (
            [measure(os.path.join(folder, subfolder), depth - 1) for subfolder in record[1]] if depth else []
        )
        has_packages = bool(record[2]) or any(child_results)
        if not record[2]:
            timings.append((time.perf_counter() - start, folder, has_packages))
        return has_packages

    for root, depth in roots:
        measure(root, depth)
    return sorted(timings, reverse=True)


def _modification_time(folder: str, name: str) -> int:
    try:
        return os.stat(folder + os.sep + name).st_mtime_ns
    except OSError:
        return 0


def _read_folder(folder: str, mtime: int) -> Record:
    with os.scandir(folder) as listing:
        entries = {entry.name: entry for entry in listing}
    manifest = next((name for name in MANIFEST_NAMES if name in entries), "")
    if manifest and "CATKIN_IGNORE" in entries:
        return [mtime, [], "", 0, "", False]
    if manifest and manifest != "stack.xml":  # packages do not nest, but stacks contain packages
        manifest_mtime = _modification_time(folder, manifest)
        name, is_meta = read_identity(folder, manifest)
        return [mtime, [], manifest, manifest_mtime, name, is_meta]
    if not _IGNORE_MARKERS.isdisjoint(entries):
        folders: list[str] = []
    else:  # broken links are kept, since their targets may appear later
        folders = sorted(
            entry_name
            for entry_name, entry in entries.items()
            if entry_name[0] != "." and (entry.is_symlink() or entry.is_dir())
        )
    if manifest:
        return [mtime, folders, manifest, _modification_time(folder, manifest), os.path.basename(folder), False]
    return [mtime, folders, "", 0, "", False]


def read_identity(folder: str, manifest: str) -> tuple[str, bool]:
    """Return the name of the package in a folder, and whether the package is a metapackage."""
    folder_name = os.path.basename(folder)
    if manifest != "package.xml":
        return folder_name, False
    try:
        text = manifest_text(os.path.join(folder, manifest))
    except OSError:
        return folder_name, False
    text = strip_comments(text)
    return package_name_in(text) or folder_name, "<metapackage" in text


def _load_records(file: str) -> dict[str, Record]:
    try:
        version, records = json.loads(_read_file(file) if os.path.isfile(file) else b"")
    except (OSError, ValueError, TypeError, RecursionError):
        return {}
    if version != _VERSION or not isinstance(records, dict):
        return {}
    return records if all(map(_is_record, records.values())) else {}


def _read_file(file: str) -> bytes:
    with open(file, "rb") as stream:
        return stream.read()


def _is_record(value: Any) -> bool:
    match value:
        case [int(), list(folders), str(), int(), str(), bool()]:
            return all(isinstance(folder, str) and folder for folder in folders)
    return False


def _save_records(file: str, records: Mapping[str, Record]) -> None:
    """Write the records for the next command. If that fails, the next command reads all folders."""
    temporary_file = f"{file}.{os.getpid()}"
    try:
        os.makedirs(os.path.dirname(file), exist_ok=True, mode=0o700)
        with open(temporary_file, "w", encoding="utf-8") as stream:
            stream.write(json.dumps([_VERSION, records], separators=(",", ":")))
        os.replace(temporary_file, file)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary_file)
