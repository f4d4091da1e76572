"""Reads files from ROS packages by URI, for robots' meshes and textures. Files outside packages cannot be read."""

from __future__ import annotations

import os
import stat
import threading
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from urllib.parse import unquote, urlsplit

from pyros1.finding.packages import PackageIndex, enclosing_package
from pyros1.ground.errors import Error

MAX_SIZE = 64 << 20
"""Maximum size of a file in bytes."""
_MAX_URI_LENGTH = 2_000
_INDEX_MAX_AGE = 10.0
"""Seconds for which a package that is missing from the index is assumed not to exist."""
_SAFE_OPEN_FLAGS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)  # Windows has neither


class FileError(Error):
    """A URI does not refer to a readable file."""


class PackageFiles:
    """Access to the files in ROS packages.

    Args:
        make_index: creates an index of the packages. It is called again when a package is not found, since the package
            may be new, but not too often, since it takes a while.
        max_size: maximum size of a file in bytes.
        clock: returns the time in seconds.
    """

    def __init__(
        self,
        make_index: Callable[[], PackageIndex] = lambda: PackageIndex(os.environ),
        max_size: int = MAX_SIZE,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._make_index = make_index
        self._max_size = max_size
        self._lock = threading.Lock()
        self._clock = clock
        self._index: PackageIndex | None = None
        self._indexed_at = 0.0

    def read(self, uri: str) -> bytes:
        """Return a file's bytes.

        Args:
            uri: ``package://NAME/PATH``, or ``file:///PATH`` for a file in a package that is found by its name. The
                path must not contain ``..``, nor lead out of the package through a symbolic link.

        Raises:
            FileError: the file does not exist, or may not be read.
        """
        package, parts = _parse_uri(uri)
        if not package:
            return self._read_file(uri, self._path_in_package(uri, parts))
        folder = os.path.realpath(self._find_package_folder(package))
        path = os.path.realpath(os.path.join(folder, *parts))
        if os.path.commonpath([folder, path]) != folder:
            raise FileError(f"{uri} leads out of its package")
        return self._read_file(uri, path)

    def _path_in_package(self, uri: str, parts: list[str]) -> str:
        path = os.path.realpath(os.path.join(os.sep, *parts))
        try:
            folder, name = enclosing_package(Path(path))
        except (OSError, RuntimeError):  # RuntimeError: circular links
            raise FileError(f"{uri} cannot be resolved") from None
        try:
            package_folder = os.path.realpath(self._find_package_folder(name))
        except FileError:
            package_folder = ""
        # A package that is shadowed by another package of the same name is treated like a folder outside packages.
        if not package_folder or os.path.realpath(folder) != package_folder:
            raise FileError(f"{uri} is not in a package that ROS finds on this machine")
        return path

    def _find_package_folder(self, package: str) -> str:
        with self._lock:
            if self._index is not None:
                try:
                    return self._index.find_folder(package)
                except Error:
                    if self._clock() - self._indexed_at < _INDEX_MAX_AGE:
                        raise FileError(f"there is no package {package} here") from None
            self._index = self._make_index()
            try:
                return self._index.find_folder(package)
            except Error:
                raise FileError(f"there is no package {package} here") from None
            finally:
                self._indexed_at = self._clock()  # after the search, which may take a long time

    def _read_file(self, uri: str, path: str) -> bytes:
        try:
            # Links have been resolved: a link created since then is not followed. With these flags, opening a pipe does
            # not block.
            with open(path, "rb", opener=lambda name, flags: os.open(name, flags | _SAFE_OPEN_FLAGS)) as file:
                file_status = os.fstat(file.fileno())
                if not stat.S_ISREG(file_status.st_mode):
                    raise FileError(f"{uri} is not a file")
                if file_status.st_size > self._max_size:
                    raise FileError(f"{uri} has {file_status.st_size} bytes; the limit is {self._max_size}")
                return file.read(self._max_size)
        except OSError as error:
            raise FileError(f"{uri} cannot be read: {error.strerror}") from None


def _parse_uri(uri: str) -> tuple[str, list[str]]:
    if len(uri) > _MAX_URI_LENGTH:
        raise FileError(f"a URI must have at most {_MAX_URI_LENGTH} characters")
    try:
        uri.encode()
        parts = urlsplit(uri)
    except ValueError:
        raise FileError("this is not a URI") from None
    if not (parts.scheme == "package" and parts.netloc) and not (parts.scheme == "file" and not parts.netloc):
        raise FileError("only URIs of the form package://NAME/PATH, and file:///PATH within a package, are read")
    names = [name for name in unquote(parts.path).split("/") if name not in ("", ".")]
    # Reject separators in the package's name, too: the search for the package may use its name as a path.
    if not names or any(name in (".", "..") or set(name) & set("\\\0/:") for name in (parts.netloc, *names)):
        raise FileError("this does not refer to a file in a package")
    return parts.netloc, names
