"""Packages and their manifests, for the verbs of ``pkg`` that need them (L182)."""

from __future__ import annotations

from pyros1.cli.commands.pkg._rospack import PkgError, Request, packages
from pyros1.cli.records import Flag
from pyros1.finding.dependencies import Packages
from pyros1.finding.manifest import Manifest

DEPS_ONLY = Flag("--deps-only", help="leave out the package itself")


def graph(request: Request) -> tuple[Packages, str]:
    """Return all packages, and the name of the package that was given."""
    name = request.package()
    return packages(), name


def check_known(known: Packages, name: str) -> None:
    """Raise an error if a package is unknown."""
    if name not in known.by_name:
        raise PkgError(f"package '{name}' not found")


def chosen(request: Request, known: Packages, name: str) -> list[Manifest]:
    """Return the manifests of a package and its dependencies, or of the latter only, depending on the options."""
    names = [*known.needs_first(name)]
    if "deps-only" not in request.options:
        names.insert(0, name)
    return [known.manifest(each) for each in names]
