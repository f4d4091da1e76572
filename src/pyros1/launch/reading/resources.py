"""The interface through which the loader accesses files, packages, the environment and commands."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Protocol

from pyros1.ground.errors import LaunchError, PackageNotFoundError
from pyros1.ground.suggest import did_you_mean

_Names = list[str]
_Paths = list[Path]


class PackageFinder(Protocol):
    """The methods of `pyros1.finding.packages.PackageIndex` that a launch needs."""

    def find(self, name: str) -> Path:
        """Return the package's folder. Raise PackageNotFoundError if it is unknown."""

    def list(self) -> _Names:
        """Return the names of all packages."""

    def find_resource(self, package: str, filename: str) -> _Paths:
        """Return the files with this name in the package."""

    def find_executable(self, package: str, name: str) -> _Paths:
        """Return the executables with this name in the package."""

    def executables(self, package: str) -> _Names:
        """Return the names of all executables in the package. Raise PackageNotFoundError if it is unknown."""


MAX_FILE_SIZE = 64 << 20
"""Maximum size in bytes of a file or a command's output: a master would not accept a larger parameter."""


def _read_bytes(path: str) -> bytes:
    with open(path, "rb") as stream:
        return read_bounded(stream, f"[{path}]")


def read_bounded(stream: IO[bytes], name: str) -> bytes:
    """Return the content of a stream, which may be endless.

    Args:
        stream: the binary stream to read.
        name: the stream's name, for error messages.

    Raises:
        LaunchError: there are more than `MAX_FILE_SIZE` bytes.
    """
    data = stream.read(MAX_FILE_SIZE + 1)
    if len(data) > MAX_FILE_SIZE:
        raise LaunchError(f"{name} is larger than {MAX_FILE_SIZE >> 20} MiB")
    return data


def _no_commands(words: list[str]) -> str:
    raise LaunchError(f"running commands is not allowed here: {words}")


@dataclass
class Resources:
    """Access to everything outside the launch files that is needed to make a plan.

    Attributes:
        packages: finds packages.
        environ: environment variables.
        read_bytes: returns a file's content; raises OSError, or LaunchError if the file is too large.
        run_command: runs a command (a list of words) and returns its standard output; raises LaunchError.
        make_unique_suffix: returns a string that makes the name from ``$(anon x)`` unique; called once per identifier.
        read_stdin: returns the content of standard input, for the file name ``-``.
    """

    packages: PackageFinder
    environ: Mapping[str, str]
    read_bytes: Callable[[str], bytes] = _read_bytes
    run_command: Callable[[list[str]], str] = _no_commands
    make_unique_suffix: Callable[[], str] = lambda: "0"
    read_stdin: Callable[[], str] = lambda: ""

    def read_text(self, path: str) -> str:
        """Return the content of a text file.

        Raises:
            LaunchError: the file cannot be read, or is not UTF-8.
        """
        try:
            text = self.read_bytes(path).decode("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise LaunchError(f"cannot read [{path}]: {reason}") from error
        return text.replace("\r\n", "\n").replace("\r", "\n")

    def read_file(self, path: str) -> str:
        """Return the content of a regular text file. Devices and pipes are refused, since reading them may never end.

        Raises:
            LaunchError: the path is not a regular file, cannot be read, or is not UTF-8.
        """
        if os.path.exists(path) and not os.path.isfile(path):
            raise LaunchError(f"cannot read [{path}]: it is not a regular file")
        return self.read_text(path)

    def similar_file_hint(self, path: str) -> str:
        """Return a hint that names a similarly named file in the same folder; an empty string if there is none."""
        try:
            return did_you_mean(os.path.basename(path), os.listdir(os.path.dirname(path) or "."))
        except OSError:
            return ""

    def find(self, package: str, path: str = "") -> str:
        """Return the path for ``$(find package)path`` (X70).

        The first candidate is an executable with this base name in ``lib/<package>`` of an install or devel space; the
        next ones are an executable in the package's folder, and a file or folder in ``share/<package>`` of such a
        space. If none exists, the result is a path in the package's folder.

        Raises:
            LaunchError: the package is unknown.
        """
        try:
            folder = self.packages.find(package)
        except PackageNotFoundError as error:
            raise LaunchError(f"{error}{did_you_mean(package, self.packages.list())}") from error
        name = path.replace("\\", "/").removeprefix("/")
        if not name:
            return str(folder)
        spaces = [Path(part) for part in self.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if part]
        if folder.parent.name == "share":
            spaces.append(folder.parent.parent)
        lib_folders = [space / "lib" / package for space in spaces]
        in_folder = folder / name
        for candidate in [*(lib_folder / os.path.basename(name) for lib_folder in lib_folders), in_folder]:
            if candidate.is_file() and os.access(candidate, os.X_OK):
                return str(candidate)
        share_candidates = (space / "share" / package / name for space in spaces)
        return next(
            (str(candidate) for candidate in share_candidates if candidate.exists()), os.path.join(folder, name)
        )
