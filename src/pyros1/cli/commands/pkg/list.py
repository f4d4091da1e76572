"""``pkg find``, ``list``, ``list-names`` and ``list-duplicates``, which need only names and folders (L182)."""

from __future__ import annotations

import os

from pyros1.cli.commands.pkg._rospack import PkgError, Request, known_packages, pack_verb
from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument
from pyros1.cli.shared.printing import print_json
from pyros1.finding.crawl import FoundPackage, find_cached
from pyros1.finding.packages import OWN_PACKAGES


def _listed() -> dict[str, FoundPackage]:
    """Return the first location of each package, sorted."""
    first = {found.name: found for found in reversed(known_packages())}
    return {name: first[name] for name in sorted(first)}


def _find(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print a package's folder."""
    name = request.package()
    quick = find_cached(os.environ, name)
    if quick is not None and not quick.meta:
        print(quick.folder)
        return
    known = _listed()
    if name not in known:
        raise PkgError(f"package '{name}' not found{did_you_mean(name, known)}")
    print(known[name].folder)


def _list_all(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print names and folders."""
    known = _listed()
    if "json" in request.options:
        print_json({name: found.folder for name, found in known.items()})
        return
    print("".join(f"{name} {found.folder}\n" for name, found in known.items()), end="")


def _list_names(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print names."""
    request.print_names(_listed())


def _list_duplicates(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print names that several packages have, each with their folders. The first folder is the one in use."""
    folders: dict[str, list[str]] = {}
    for found in known_packages():
        if not found.folder.startswith(OWN_PACKAGES):  # these are only defaults for missing packages
            folders.setdefault(found.name, []).append(found.folder)
    for name, places in sorted(folders.items()):
        if len(places) > 1:
            print(name, *(f"- {place}" for place in places), sep="\n")


VERBS = [
    pack_verb(
        "find",
        "find [package]",
        Argument("package", "package", optional=True),
        run=_find,
        examples=[("roscpp", "its folder")],
    ),
    pack_verb("list", "list", JSON, run=_list_all, examples=[("", "names and folders"), ("--json", "for programs")]),
    pack_verb("list-names", "list-names", JSON, run=_list_names, examples=[("", "names")]),
    pack_verb(
        "list-duplicates",
        "list-duplicates",
        run=_list_duplicates,
        examples=[("", "names of several packages, with the folders")],
    ),
]
