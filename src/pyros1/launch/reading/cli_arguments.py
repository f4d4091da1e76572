"""Finds the launch files and their arguments in the words of a command line (X01, X03, X05)."""

from __future__ import annotations

import os
import re
import sys

from pyros1.finding.packages import OWN_PACKAGES
from pyros1.ground.errors import LaunchError, PackageNotFoundError
from pyros1.ground.suggest import argument_hint, did_you_mean
from pyros1.launch.reading.loader import STDIN_NAME
from pyros1.launch.reading.resources import Resources

_MAX_NAMES_SHOWN = 20
_ARGUMENT_PATTERN = re.compile(r"[A-Za-z~/_][\w/]*:=.*")


class CommandLineError(LaunchError):
    """The command line does not specify existing launch files."""


def parse_arguments(argv: list[str]) -> dict[str, str]:
    """Return the ``name:=value`` arguments of a command line (X03).

    Names without a value and names that start with ``_``, which are a node's parameters, are ignored. Arguments with a
    second ``:=`` are also ignored, but reported on stderr.
    """
    arguments: dict[str, str] = {}
    for word in argv:
        if not _ARGUMENT_PATTERN.fullmatch(word):
            continue
        name, value, *more = (part.strip() for part in word.split(":="))
        if more:
            sys.stderr.write(f"ERROR: Invalid remapping argument '{word}'\n")
        elif value and (not name.startswith("_") or name.startswith("__") or name == "_"):
            arguments[name] = value
    return arguments


def find_launch_files(words: list[str], resources: Resources) -> list[str]:
    """Convert ``pkg file``, ``file...`` and ``-`` to paths (X01, X05).

    A name that is not a file in the current folder may also name a launch file in one of pyros1's own packages.

    Args:
        words: the command line without options and ``name:=value`` arguments.
        resources: finds packages.

    Raises:
        CommandLineError: the command line does not specify existing launch files.
        LaunchError: a file does not exist.
    """
    if words.count(STDIN_NAME) > 1:
        raise CommandLineError("Only a single instance of the dash ('-') may be specified.")
    if len(words) > 1 and words[0] != STDIN_NAME:
        path = _in_package(words[0], words[1], resources)
        if path:
            words = [path, *words[2:]]
        elif not os.path.isfile(words[0]):
            package, file = words[:2]
            alternative = argument_hint(file)
            if alternative:
                hint = f"; {alternative}"
            elif _is_package(package, resources):
                hint = _files_hint(package, file, resources)
            else:
                hint = f": package [{package}] not found{did_you_mean(package, resources.packages.list())}"
            raise LaunchError(
                f"[{file}] is neither a launch file in package [{package}] nor is [{package}] a launch file name{hint}"
            )
    if len(words) == 1 and words[0] != STDIN_NAME and not os.path.isfile(words[0]):
        own_file = _own_file(words[0])
        if own_file is None:
            hint = resources.similar_file_hint(words[0])
            if not hint and _is_package(words[0], resources):
                hint = _files_hint(words[0], "", resources)
            raise LaunchError(f"[{words[0]}] is not a launch file name{hint}")
        return [own_file]
    missing = [word for word in words if word != STDIN_NAME and not os.path.exists(word)]
    if missing:
        hints = [f"\n{hint}" for hint in map(argument_hint, missing) if hint]
        raise CommandLineError(f"The following input files do not exist: {', '.join(missing)}{''.join(hints)}")
    return words


def _is_package(name: str, resources: Resources) -> bool:
    try:
        resources.packages.find(name)
    except PackageNotFoundError:
        return False
    return True


def _files_hint(package: str, file: str, resources: Resources) -> str:
    """Return a hint that lists a package's launch files, to append to a message that a file is not in the package."""
    names: set[str] = set()
    for _, folders, files in os.walk(resources.packages.find(package)):
        folders[:] = [name for name in folders if name[0] != "."]
        names.update(name for name in files if name.endswith((".launch", ".launch.xml", ".test")))
    if not names:
        return f"; package [{package}] has no launch files"
    others = f" and {len(names) - _MAX_NAMES_SHOWN} more" if len(names) > _MAX_NAMES_SHOWN else ""
    return f"{did_you_mean(file, names)}; package [{package}] has {', '.join(sorted(names)[:_MAX_NAMES_SHOWN])}{others}"


def _in_package(package: str, file: str, resources: Resources) -> str | None:
    try:
        found_paths = resources.packages.find_resource(package, file)
    except PackageNotFoundError:
        return None
    if len(found_paths) > 1:
        listing = "\n".join(f" * {path}" for path in found_paths)
        raise LaunchError(
            f"multiple files named [{file}] in package [{package}]:\n{listing}\nPlease specify full path instead"
        )
    return str(found_paths[0]) if found_paths else None


def _own_file(name: str) -> str | None:
    if os.path.dirname(name):
        return None
    files = (os.path.join(OWN_PACKAGES, package, "launch", name) for package in sorted(os.listdir(OWN_PACKAGES)))
    return next(filter(os.path.isfile, files), None)
