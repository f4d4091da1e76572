"""``pkg find``, ``list``, ``list-names`` and ``list-duplicates``: print names and folders of packages (L182)."""

from __future__ import annotations

import os

from pyros1.cli.commands.pkg._rospack import PkgError, Request, known_packages, make_verb
from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument
from pyros1.cli.shared.printing import print_json
from pyros1.finding.crawl import FoundPackage, find_cached
from pyros1.finding.packages import OWN_PACKAGES


def _packages_by_name() -> dict[str, FoundPackage]:
    """Return the first package with each name, sorted by name."""
    first_packages = {package.name: package for package in reversed(known_packages())}
    return {name: first_packages[name] for name in sorted(first_packages)}


def _print_folder(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print a package's folder."""
    package_name = request.package()
    cached = find_cached(os.environ, package_name)
    if cached is not None and not cached.is_meta:
        print(cached.folder)
        return
    packages_by_name = _packages_by_name()
    if package_name not in packages_by_name:
        raise PkgError(f"package '{package_name}' not found{did_you_mean(package_name, packages_by_name)}")
    print(packages_by_name[package_name].folder)


def _list_all(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the names and folders of all packages."""
    packages_by_name = _packages_by_name()
    if "json" in request.options:
        print_json({name: package.folder for name, package in packages_by_name.items()})
        return
    print("".join(f"{name} {package.folder}\n" for name, package in packages_by_name.items()), end="")


def _list_names(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the names of all packages."""
    request.print_names(_packages_by_name())


def _list_duplicates(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print names that several packages share, with their folders. The first folder is the one in use."""
    folders_by_name: dict[str, list[str]] = {}
    for package in known_packages():
        if not package.folder.startswith(OWN_PACKAGES):  # pyros1's own packages only replace missing ones
            folders_by_name.setdefault(package.name, []).append(package.folder)
    for name, locations in sorted(folders_by_name.items()):
        if len(locations) > 1:
            print(name, *(f"- {location}" for location in locations), sep="\n")


VERBS = [
    make_verb(
        "find",
        "find [package]",
        Argument("package", "package", optional=True),
        run=_print_folder,
        examples=[("roscpp", "print the folder of a package")],
    ),
    make_verb(
        "list",
        "list",
        JSON_FLAG,
        run=_list_all,
        examples=[("", "list the names and folders of all packages"), ("--json", "print JSON for programs")],
    ),
    make_verb(
        "list-names", "list-names", JSON_FLAG, run=_list_names, examples=[("", "list the names of all packages")]
    ),
    make_verb(
        "list-duplicates",
        "list-duplicates",
        run=_list_duplicates,
        examples=[("", "list names that several packages share, with their folders")],
    ),
]
