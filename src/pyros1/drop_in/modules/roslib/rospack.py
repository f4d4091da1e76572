"""Functions that return the results of the command rospack."""

from __future__ import annotations

import os
from collections.abc import Callable

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.finding.crawl import all_packages
from pyros1.finding.dependencies import Packages
from pyros1.ground.errors import Error

_REASON = "use rospkg.RosPack and the get_export of its manifests"
_STACKS = "stacks were part of rosbuild; use rospkg.RosPack"
_COMMANDS: dict[str, Callable[[Packages, str], list[str]]] = {
    "find": lambda packages, name: [packages.find(name).folder],
    "depends": Packages.dependencies,
    "depends1": Packages.direct_dependencies,
    "depends-on": lambda packages, name: packages.all_dependents(packages.find(name).name),
    "depends-on1": lambda packages, name: packages.dependents(packages.find(name).name),
}

__getattr__ = module_getattr(__name__, rospack_plugins=_REASON, rosstackexec=_STACKS, rosstack_depends=_STACKS)


def rospackexec(args: list[str]) -> str:
    """Return the output of ``rospack``: find, depends, depends1, depends-on, depends-on1 and list-names.

    The output is empty for other commands and for commands that would fail.
    """
    known_packages = [
        package for package in all_packages(os.environ) if package.manifest in ("package.xml", "manifest.xml")
    ]
    packages = Packages(known_packages)
    if args == ["list-names"]:
        return "\n".join(sorted(packages.by_name))
    try:
        return "\n".join(_COMMANDS[args[0]](packages, args[1]))
    except (Error, LookupError):
        return ""


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
