"""Answers of the commands rospack and rosstack."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import chain

from pyros1.drop_in.missing import missing
from pyros1.finding.crawl import all_packages
from pyros1.finding.dependencies import Packages
from pyros1.ground.errors import Error

python3 = True
__getattr__ = missing(__name__)


def _packages(stacks: bool) -> Packages:
    """Return what each command knows: packages that are no metapackages, and of stacks all of catkin's."""
    wanted = ("package.xml", "stack.xml") if stacks else ("package.xml", "manifest.xml")
    return Packages([each for each in all_packages(os.environ) if each.manifest in wanted])


def _execute(args: list[str], stacks: bool) -> str:
    commands: dict[str, Callable[[Packages, str], list[str]]] = {
        "find": lambda packages, name: [packages.find(name).folder],
        "depends": Packages.needs,
        "depends1": Packages.direct,
        "depends-on": lambda packages, name: packages.all_needed_by(packages.find(name).name),
        "depends-on1": lambda packages, name: packages.needed_by(packages.find(name).name),
    }
    if args == ["list-names"]:
        return "\n".join(sorted(_packages(stacks).by_name))
    if len(args) != 2 or args[0] not in commands:
        return ""
    try:
        return "\n".join(commands[args[0]](_packages(stacks), args[1]))
    except Error:
        return ""


def rospackexec(args: list[str]) -> str:
    """Return what ``rospack`` would print: find, depends, depends1, depends-on, depends-on1 and list-names.

    It is empty for other commands, and if it would fail.
    """
    return _execute(args, stacks=False)


def rosstackexec(args: list[str]) -> str:
    """Return what ``rosstack`` would print; see `rospackexec`."""
    return _execute(args, stacks=True)


def rospack_depends_1(pkg: str) -> list[str]:
    """Return the packages that a package needs directly at run time."""
    return rospackexec(["depends1", pkg]).split()


def rospack_depends(pkg: str) -> list[str]:
    """Return all packages that a package needs at run time."""
    return rospackexec(["depends", pkg]).split()


def rospack_depends_on_1(pkg: str) -> list[str]:
    """Return the packages that need a package directly."""
    return rospackexec(["depends-on1", pkg]).split()


def rospack_depends_on(pkg: str) -> list[str]:
    """Return all packages that need a package."""
    return rospackexec(["depends-on", pkg]).split()


def rospack_plugins(pkg: str) -> list[tuple[str, str]]:
    """Return (package, plugin) of the packages that need a package directly and export a plugin for it."""
    packages = _packages(stacks=False)
    found = (
        [(each, value) for value in packages.manifest(each).exported(pkg, "plugin")] for each in packages.needed_by(pkg)
    )
    return list(chain.from_iterable(found))


def rosstack_depends_1(s: str) -> list[str]:
    """Return the stacks that a stack needs directly."""
    return rosstackexec(["depends1", s]).split()


def rosstack_depends(s: str) -> list[str]:
    """Return all stacks that a stack needs."""
    return rosstackexec(["depends", s]).split()


def rosstack_depends_on_1(s: str) -> list[str]:
    """Return the stacks that need a stack directly."""
    return rosstackexec(["depends-on1", s]).split()


def rosstack_depends_on(s: str) -> list[str]:
    """Return all stacks that need a stack."""
    return rosstackexec(["depends-on", s]).split()
