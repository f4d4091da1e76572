"""All packages of this machine, from a crawl of the folders whose results are cached between commands.

The record of a crawl holds the modification time and the content of each folder. A later command asks the system only
for the times, and reads the folders that have changed: what was added, moved or removed is seen at once. Folders that
changed just now are not recorded, since a second change within the clock's granularity would not show.
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

MANIFESTS = ("package.xml", "manifest.xml", "stack.xml")
_IGNORED = frozenset({"CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs"})
_VERSION = 1
_MIN_TRUSTED_AGE = 2_000_000_000  # ns; file systems with the coarsest clocks count in steps of two seconds

# One folder's record: [time of change, names of folders in it, manifest's file name, its time, package name, meta?]
Record = list[Any]


class FoundPackage(NamedTuple):
    """A package on this machine.

    Attributes:
        name: the package's name.
        folder: its path.
        manifest: file name of its manifest: ``package.xml``, ``manifest.xml`` or ``stack.xml`` (a stack of rosbuild).
        meta: whether it is a metapackage.
    """

    name: str
    folder: str
    manifest: str
    meta: bool

    @property
    def catkin(self) -> bool:
        """Whether it is a catkin package, not one of rosbuild."""
        return self.manifest == "package.xml"


def search_folders(environ: Mapping[str, str]) -> list[tuple[str, int]]:
    """Return the folders in which packages are searched, in order, each with the number of levels to search."""
    return [(_normalized(folder), depth) for folder, depth in PackageIndex(environ).search_folders()]


def _normalized(folder: str) -> str:
    """Return a path as ``pathlib`` writes it: loading that module takes much of a short command's time."""
    steps = "/".join(step for step in folder.split("/") if step not in ("", "."))
    return f"/{steps}" if folder.startswith("/") else steps or "."


def cache_folder(environ: Mapping[str, str]) -> str:
    """Return the cache folder: ``$XDG_CACHE_HOME/pyros1`` or ``~/.cache/pyros1``."""
    base = environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return os.path.join(base, "pyros1")


def all_packages(environ: Mapping[str, str], *, roots: list[tuple[str, int]] | None = None) -> list[FoundPackage]:
    """Return all packages in the order in which they are found; of several with the same name the first counts.

    Below one root, a package in a folder of its name directly in the root comes first, as for `PackageIndex`.

    Args:
        environ: environment variables: they say where to search and where the cache is.
        roots: the folders to search, each with the number of levels; None means those of this machine.
    """
    roots = search_folders(environ) if roots is None else roots
    file = _record_file(environ, roots)
    crawl = Crawl(_load(file))
    found: dict[str, FoundPackage] = {}
    for root, depth in roots:
        below = list(crawl.packages(root, depth))
        direct = {package.name for package in below if _is_direct(package, root)}
        for package in sorted(below, key=lambda package: package.name in direct and not _is_direct(package, root)):
            found.setdefault(package.folder, package)
    if crawl.changed:
        _save(file, crawl.trusted_records())
    return list(found.values())


def find_cached(environ: Mapping[str, str], name: str) -> FoundPackage | None:
    """Return a package from the record of an earlier crawl, without a check of all other packages.

    Folders that hold packages are checked, and so is the package itself.

    Args:
        environ: environment variables: they say where to search and where the cache is.
        name: the package's name.

    Returns:
        The package; None if a full crawl (:func:`all_packages`) must answer: something has changed, or there is no such
        package.
    """
    roots = search_folders(environ)
    records = _load(_record_file(environ, roots))
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
    """Yield the packages of that name; raise LookupError if a record is missing or too old."""
    record = records.get(folder)
    if record is None:
        if os.path.isdir(folder):
            raise LookupError
        return
    changed, folders, manifest, written, package, meta = record
    if not manifest or package == name:
        if os.stat(folder).st_mtime_ns != changed or (manifest and _changed(folder, manifest) != written):
            raise LookupError
        if manifest:
            yield FoundPackage(package, folder, manifest, meta)
    if depth > 0:
        for each in folders:
            path = f"{folder.rstrip('/')}/{each}"
            known = records.get(path)
            if known is None or not known[2] or known[4] == name or known[1]:  # else: another package
                yield from _cached_packages(records, path, depth - 1, name)


def _record_file(environ: Mapping[str, str], roots: list[tuple[str, int]]) -> str:
    # If two sets of places had the same number, they would share a file; the other's records do no harm.
    return os.path.join(cache_folder(environ), f"packages-{crc32(repr(roots).encode()):08x}.json")


class Crawl:
    """A walk through folders with the help of the records of an earlier one.

    Args:
        records: folder -> record.
        now: the present time in nanoseconds; None: by the clock.

    Attributes:
        changed: whether something differed from the records.
    """

    def __init__(self, records: Mapping[str, Record], now: int | None = None) -> None:
        self._old = records
        self._new: dict[str, Record] = {}
        self._seen: set[tuple[int, int]] = set()  # folders entered below a root: no link leads to one of them again
        self._now = time.time_ns() if now is None else now
        self.changed = False

    def packages(self, folder: str, depth: int, ancestors: tuple[tuple[int, int], ...] = ()) -> Iterator[FoundPackage]:
        """Yield the packages in a folder and below, in the order of their names.

        Args:
            folder: the folder to search.
            depth: number of levels to search.
            ancestors: device and inode of the folders on the way, so that links that lead back are not followed.
        """
        try:
            status = os.stat(folder)
        except OSError:
            return
        if not ancestors:
            self._seen.clear()
        here = (status.st_dev, status.st_ino)
        if here in ancestors or (here in self._seen and os.path.islink(folder)):
            return
        self._seen.add(here)
        record = self._record(folder, status.st_mtime_ns)
        if record is None:
            return
        _, folders, manifest, _, name, meta = record
        if manifest:
            yield FoundPackage(name, folder, manifest, meta)
        if depth > 0:
            for each in folders:
                yield from self.packages(f"{folder.rstrip('/')}/{each}", depth - 1, (*ancestors, here))

    def trusted_records(self) -> dict[str, Record]:
        """Return the records that a later walk may rely on."""
        limit = self._now - _MIN_TRUSTED_AGE
        return {folder: record for folder, record in self._new.items() if max(record[0], record[3]) < limit}

    def _record(self, folder: str, changed: int) -> Record | None:
        record = self._old.get(folder)
        if record is None or record[0] != changed or (record[2] and _changed(folder, record[2]) != record[3]):
            try:
                record = _read(folder, changed)
            except OSError:
                return None
            self.changed = True
        self._new[folder] = record
        return record


def profile(roots: list[tuple[str, int]]) -> list[tuple[float, str, bool]]:
    """Return the seconds that it takes to read each folder, with all below it, without a record; slowest first.

    Args:
        roots: the folders to search, each with the number of levels.

    Returns:
        (seconds, folder, whether it or a folder below holds a package) of each folder.
    """
    result: list[tuple[float, str, bool]] = []

    seen: set[str] = set()

    def walk(folder: str, depth: int) -> bool:
        start = time.perf_counter()
        real = os.path.realpath(folder)
        if real in seen:
            return True
        seen.add(real)
        try:
            record = _read(folder, 0)
        except OSError:
            return False
        inside = [walk(os.path.join(folder, each), depth - 1) for each in record[1]] if depth else []
        holds = bool(record[2]) or any(inside)
        if not record[2]:
            result.append((time.perf_counter() - start, folder, holds))
        return holds

    for root, depth in roots:
        walk(root, depth)
    return sorted(result, reverse=True)


def _changed(folder: str, name: str) -> int:
    try:
        return os.stat(folder + os.sep + name).st_mtime_ns
    except OSError:
        return 0


def _read(folder: str, changed: int) -> Record:
    with os.scandir(folder) as listing:
        entries = {entry.name: entry for entry in listing}
    manifest = next((name for name in MANIFESTS if name in entries), "")
    if manifest and "CATKIN_IGNORE" in entries:
        return [changed, [], "", 0, "", False]
    if manifest and manifest != "stack.xml":  # packages do not nest; stacks hold packages
        time_read = _changed(folder, manifest)
        name, meta = identity(folder, manifest)
        return [changed, [], manifest, time_read, name, meta]
    if not _IGNORED.isdisjoint(entries):
        folders: list[str] = []
    else:  # broken links stay in the list: their targets may appear later
        folders = sorted(n for n, entry in entries.items() if n[0] != "." and (entry.is_symlink() or entry.is_dir()))
    if manifest:
        return [changed, folders, manifest, _changed(folder, manifest), os.path.basename(folder), False]
    return [changed, folders, "", 0, "", False]


def identity(folder: str, manifest: str) -> tuple[str, bool]:
    """Return the package name in a manifest, and whether the package is a metapackage."""
    base = os.path.basename(folder)
    if manifest != "package.xml":
        return base, False
    try:
        text = manifest_text(os.path.join(folder, manifest))
    except OSError:
        return base, False
    text = strip_comments(text)
    return package_name_in(text) or base, "<metapackage" in text


def _load(file: str) -> dict[str, Record]:
    try:
        version, records = json.loads(_content(file) if os.path.isfile(file) else b"")
    except (OSError, ValueError, TypeError, RecursionError):
        return {}
    if version != _VERSION or not isinstance(records, dict):
        return {}
    return records if all(map(_is_record, records.values())) else {}


def _content(file: str) -> bytes:
    with open(file, "rb") as stream:
        return stream.read()


def _is_record(value: Any) -> bool:
    match value:
        case [int(), list(folders), str(), int(), str(), bool()]:
            return all(isinstance(folder, str) and folder for folder in folders)
    return False


def _save(file: str, records: Mapping[str, Record]) -> None:
    """Write the records for the next command. If that fails, the next command reads the folders itself."""
    temporary = f"{file}.{os.getpid()}"
    try:
        os.makedirs(os.path.dirname(file), exist_ok=True, mode=0o700)
        with open(temporary, "w", encoding="utf-8") as stream:
            stream.write(json.dumps([_VERSION, records], separators=(",", ":")))
        os.replace(temporary, file)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
