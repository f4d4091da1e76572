"""What planning takes from the world: files, packages, the environment, commands; the loader has no other way there."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from pyros1.errors import LaunchError, PackageNotFoundError


class PackageFinder(Protocol):
    """The part of `pyros1.msgs.packages.PackageIndex` that launching needs."""

    def find(self, name: str) -> Path:
        """Return the package's folder; raises PackageNotFoundError."""

    def find_resource(self, package: str, filename: str) -> list[Path]:
        """Return the files of that name below the package."""

    def find_executable(self, package: str, name: str) -> list[Path]:
        """Return the executables of that name in the package."""


def _read_bytes(path: str) -> bytes:
    with open(path, "rb") as stream:
        return stream.read()


def _no_commands(words: list[str]) -> str:
    raise LaunchError(f"no commands are run here: {words}")


@dataclass
class Resources:
    """Where a plan's ingredients come from.

    Attributes:
        packages: finds packages.
        environ: environment variables.
        read_bytes: reads a file; raises OSError.
        run_command: runs a command given as words and returns its standard output; raises LaunchError.
        unique: text that makes ``$(anon x)`` unique, called once per identifier.
        stdin: reads standard input, for ``-``.
    """

    packages: PackageFinder
    environ: Mapping[str, str]
    read_bytes: Callable[[str], bytes] = _read_bytes
    run_command: Callable[[list[str]], str] = _no_commands
    unique: Callable[[], str] = lambda: "0"
    stdin: Callable[[], str] = lambda: ""
    _text_cache: dict[str, str] = field(default_factory=dict)

    def read_text(self, path: str) -> str:
        """Return a file as text.

        Raises:
            LaunchError: it cannot be read, or is not UTF-8.
        """
        try:
            return self.read_bytes(path).decode("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise LaunchError(f"cannot read [{path}]: {reason}") from error

    def find(self, package: str, path: str = "") -> str:
        """Return what ``$(find package)path`` means: an executable in ``lib/<package>``, else a path in the package.

        Raises:
            LaunchError: no such package.
        """
        try:
            folder = self.packages.find(package)
        except PackageNotFoundError as error:
            raise LaunchError(str(error)) from error
        name = path.lstrip("/\\")
        if name and folder.parent.name == "share":
            candidate = folder.parent.parent / "lib" / package / name
            if candidate.is_file() and os.access(candidate, os.X_OK):
                return str(candidate)
        return str(folder) + path
