"""Shared code of the verbs of ``pkg`` that inspect dependencies: packages and their manifests (L182)."""

from __future__ import annotations

from pyros1.cli.commands.pkg._rospack import PkgError, Request, load_packages
from pyros1.cli.records import Flag
from pyros1.finding.dependencies import Packages
from pyros1.finding.manifest import Manifest

DEPS_ONLY_FLAG = Flag("--deps-only", help="leave out the package itself")


def packages_and_name(request: Request) -> tuple[Packages, str]:
    """Return all packages and the name of the requested package."""
    package_name = request.package()
    return load_packages(), package_name


def check_known(packages: Packages, package: str) -> None:
    """Raise `PkgError` if a package is unknown."""
    if package not in packages.by_name:
        raise PkgError(f"package '{package}' not found")


def selected_manifests(request: Request, packages: Packages, package_name: str) -> list[Manifest]:
    """Return the manifests of a package and its dependencies; with ``--deps-only``, only of the dependencies."""
    names = [*packages.dependencies_top_down(package_name)]
    if "deps-only" not in request.options:
        names.insert(0, package_name)
    return [packages.manifest(package) for package in names]
