"""Dependencies between packages, by rospack's rules."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from pyros1.finding.crawl import FoundPackage
from pyros1.finding.manifest import Manifest, ManifestError, read_manifest
from pyros1.ground.errors import PackageNotFoundError


class Packages:
    """Packages and their dependencies; manifests are read when they are needed.

    Args:
        found: the packages, in the order of preference; of several with the same name the first counts.
    """

    def __init__(self, found: Sequence[FoundPackage]) -> None:
        self.all = found
        self.by_name: dict[str, FoundPackage] = {}
        for package in found:
            self.by_name.setdefault(package.name, package)
        self._manifests: dict[str, Manifest] = {}

    def find(self, name: str) -> FoundPackage:
        """Return a package.

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
            ManifestError: it cannot be read.
        """
        manifest = self._manifests.get(name)
        if manifest is None:
            package = self.find(name)
            manifest = read_manifest(Path(package.folder, package.manifest), name)
            self._manifests[name] = manifest
        return manifest

    def direct(self, name: str) -> list[str]:
        """Return the direct dependencies of a package; names that are not packages are dependencies on the system.

        Raises:
            ManifestError: a rosbuild package names a package that does not exist, or a manifest cannot be read.
        """
        manifest = self.manifest(name)
        names = manifest.runs_with()
        missing = [each for each in names if each not in self.by_name]
        if missing and not manifest.catkin:
            raise ManifestError(f"package '{name}' depends on non-existent package '{missing[0]}'")
        return [each for each in names if each in self.by_name]

    def needs(self, name: str) -> list[str]:
        """Return all dependencies of a package, direct and indirect, each one before those that need it."""
        return list(self._after(name, {name}))

    def needs_first(self, name: str) -> list[str]:
        """Return all dependencies of a package, direct and indirect, each one after those that need it."""
        result: dict[str, None] = {}
        waiting = [*reversed(self.direct(name))]
        while waiting:
            each = waiting.pop()
            if each not in result and each != name:
                result[each] = None
                waiting += reversed(self.direct(each))
        return list(result)

    def needed_by(self, name: str) -> list[str]:
        """Return the packages that depend on a package directly, sorted."""
        return sorted(each for each in self.by_name if name in self._known(each))

    def all_needed_by(self, name: str) -> list[str]:
        """Return the packages that depend on a package, directly or through others, sorted."""
        users: dict[str, list[str]] = {}
        for each in self.by_name:
            for needed in self._known(each):
                users.setdefault(needed, []).append(each)
        result: set[str] = set()
        waiting = list(users.get(name, []))
        while waiting:
            each = waiting.pop()
            if each not in result:
                result.add(each)
                waiting += users.get(each, [])
        return sorted(result - {name})

    def tree(self, name: str, level: int = 0, above: tuple[str, ...] = ()) -> Iterator[tuple[int, str]]:
        """Yield (level, package) of the tree of a package's dependencies, from the top down."""
        for each in self.direct(name):
            yield level, each
            if each not in above:
                yield from self.tree(each, level + 1, (*above, name))

    def chains(self, name: str, target: str) -> Iterator[tuple[str, ...]]:
        """Yield all chains of dependencies from one package to another."""
        leading = {target, *self.all_needed_by(target)}
        yield from self._chains((name,), target, leading)

    def _chains(self, way: tuple[str, ...], target: str, leading: set[str]) -> Iterator[tuple[str, ...]]:
        for each in self.direct(way[-1]):
            if each == target:
                yield (*way, each)
            elif each in leading and each not in way:
                yield from self._chains((*way, each), target, leading)

    def _after(self, name: str, seen: set[str]) -> Iterator[str]:
        for each in self.direct(name):
            if each not in seen:
                seen.add(each)
                yield from self._after(each, seen)
                yield each

    def _known(self, name: str) -> Iterable[str]:
        """Return a package's direct dependencies, none if its manifest is broken: that must not stop a search."""
        try:
            return self.manifest(name).runs_with()
        except ManifestError:
            return []
