"""Determines dependencies between packages, by rospack's rules."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from pyros1.finding.crawl import FoundPackage
from pyros1.finding.manifest import Manifest, ManifestError, read_manifest
from pyros1.ground.errors import PackageNotFoundError


class Packages:
    """Packages and their dependencies; manifests are read when needed.

    Args:
        packages: the packages in order of precedence; if several have the same name, the first one is used.
    """

    def __init__(self, packages: Sequence[FoundPackage]) -> None:
        self.all = packages
        self.by_name: dict[str, FoundPackage] = {}
        for package in packages:
            self.by_name.setdefault(package.name, package)
        self._manifests: dict[str, Manifest] = {}

    def find(self, name: str) -> FoundPackage:
        """Return the package with the given name.

        Raises:
            PackageNotFoundError: there is no such package.
        """
        package = self.by_name.get(name)
        if package is None:
            raise PackageNotFoundError(name)
        return package

    def manifest(self, name: str) -> Manifest:
        """Return a package's manifest.

        Raises:
            PackageNotFoundError: there is no such package.
            ManifestError: the manifest cannot be read.
        """
        manifest = self._manifests.get(name)
        if manifest is None:
            package = self.find(name)
            manifest = read_manifest(Path(package.folder, package.manifest), name)
            self._manifests[name] = manifest
        return manifest

    def direct_dependencies(self, name: str) -> list[str]:
        """Return the packages on which a package depends directly; system dependencies are left out.

        Raises:
            PackageNotFoundError: there is no such package.
            ManifestError: a rosbuild package depends on a package that does not exist, or a manifest cannot be read.
        """
        manifest = self.manifest(name)
        names = manifest.run_dependencies()
        missing = [dependency for dependency in names if dependency not in self.by_name]
        if missing and not manifest.is_catkin:
            raise ManifestError(f"package '{name}' depends on non-existent package '{missing[0]}'")
        return [dependency for dependency in names if dependency in self.by_name]

    def dependencies(self, name: str) -> list[str]:
        """Return all direct and indirect dependencies of a package, each one before the packages that need it."""
        return list(self._visit_dependencies(name, {name}))

    def dependencies_top_down(self, name: str) -> list[str]:
        """Return all direct and indirect dependencies of a package, each one after the packages that need it."""
        result: dict[str, None] = {}
        pending = [*reversed(self.direct_dependencies(name))]
        while pending:
            dependency = pending.pop()
            if dependency not in result and dependency != name:
                result[dependency] = None
                pending += reversed(self.direct_dependencies(dependency))
        return list(result)

    def dependents(self, name: str) -> list[str]:
        """Return the packages that depend on a package directly, sorted."""
        return sorted(dependent for dependent in self.by_name if name in self._dependencies_or_empty(dependent))

    def all_dependents(self, name: str) -> list[str]:
        """Return the packages that depend on a package directly or indirectly, sorted."""
        dependents: dict[str, list[str]] = {}
        for package_name in self.by_name:
            for dependency in self._dependencies_or_empty(package_name):
                dependents.setdefault(dependency, []).append(package_name)
        result: set[str] = set()
        pending = list(dependents.get(name, []))
        while pending:
            dependent = pending.pop()
            if dependent not in result:
                result.add(dependent)
                pending += dependents.get(dependent, [])
        return sorted(result - {name})

    def tree(self, name: str, level: int = 0, ancestors: tuple[str, ...] = ()) -> Iterator[tuple[int, str]]:
        """Yield (level, package) for each entry in the tree of a package's dependencies, from the top down."""
        for dependency in self.direct_dependencies(name):
            yield level, dependency
            if dependency not in ancestors:
                yield from self.tree(dependency, level + 1, (*ancestors, name))

    def chains(self, name: str, target: str) -> Iterator[tuple[str, ...]]:
        """Yield all chains of dependencies from one package to another, both included."""
        candidates = {target, *self.all_dependents(target)}
        yield from self._chains((name,), target, candidates)

    def _chains(self, chain: tuple[str, ...], target: str, candidates: set[str]) -> Iterator[tuple[str, ...]]:
        for dependency in self.direct_dependencies(chain[-1]):
            if dependency == target:
                yield (*chain, dependency)
            elif dependency in candidates and dependency not in chain:
                yield from self._chains((*chain, dependency), target, candidates)

    def _visit_dependencies(self, name: str, visited: set[str]) -> Iterator[str]:
        for dependency in self.direct_dependencies(name):
            if dependency not in visited:
                visited.add(dependency)
                yield from self._visit_dependencies(dependency, visited)
                yield dependency

    def _dependencies_or_empty(self, name: str) -> Iterable[str]:
        """Return a package's direct dependencies; empty if its manifest is invalid, since one invalid manifest must not
        stop a search.
        """
        try:
            return self.manifest(name).run_dependencies()
        except ManifestError:
            return []
