"""The verbs of ``pkg`` and ``stack`` that need only names and folders (L182, L183)."""

from __future__ import annotations

import os

from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.cli.shared.rospack.tool import PkgError, Request, known_to, listed, pack_verb
from pyros1.finding.crawl import find_quickly
from pyros1.finding.packages import OWN_PACKAGES


def _find(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print a package's folder."""
    name = request.package()
    quick = find_quickly(os.environ, name) if request.stock == "rospack" else None
    if quick is not None and not quick.meta:
        print(quick.folder)
        return
    known = listed(request)
    if name not in known:
        hint = did_you_mean(name, known)
        raise PkgError(f"{request.unit} '{name}' not found{hint}")
    print(known[name].folder)


def _list_all(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print names and folders."""
    known = listed(request)
    if "json" in request.options:
        print_json({name: found.folder for name, found in known.items()})
        return
    print("".join(f"{name} {found.folder}\n" for name, found in known.items()), end="")


def _list_names(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print names."""
    request.print_names(listed(request))


def _list_duplicates(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print names that several packages have, each with their folders. The first folder is the one in use."""
    folders: dict[str, list[str]] = {}
    for found in known_to(request.stock):
        if not found.folder.startswith(OWN_PACKAGES):  # these are only defaults for missing packages
            folders.setdefault(found.name, []).append(found.folder)
    for name, places in sorted(folders.items()):
        if len(places) > 1:
            print(name, *(f"- {place}" for place in places), sep="\n")


def find_verb(unit: str) -> Verb:
    """Return the record of ``find``. `unit` is ``package`` or ``stack``."""
    package = Argument(unit, "package", optional=True)
    return pack_verb("find", f"find [{unit}]", package, run=_find, examples=[("roscpp", "its folder")])


def list_verbs(*, duplicates: bool) -> list[Verb]:
    """Return the records of ``list`` and similar verbs. `duplicates`: stock's list has ``list-duplicates``."""
    return [
        pack_verb(
            "list", "list", JSON, run=_list_all, examples=[("", "names and folders"), ("--json", "for programs")]
        ),
        pack_verb("list-names", "list-names", JSON, run=_list_names, examples=[("", "names")]),
        pack_verb(
            "list-duplicates",
            "list-duplicates",
            run=_list_duplicates,
            examples=[("", "names of several packages, with the folders")],
            stock_about=None if duplicates else "",
        ),
    ]
