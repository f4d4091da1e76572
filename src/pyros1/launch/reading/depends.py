"""Which packages launch files need, and which of those their own package does not declare (L174, L175)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from pyros1.errors import LaunchError
from pyros1.finding.packages import package_of
from pyros1.launch.plan import Plan

_DECLARING = ("depend", "exec_depend", "run_depend")


@dataclass
class FileNeeds:
    """What one launch file needs.

    Attributes:
        file: its path as it was written.
        package: the package that it belongs to, None if it is in none.
        nodes: ``(package, executable)`` of its nodes and tests, in order, each once.
        packages: the packages of those and of other packages' files that it includes, in order, each once.
    """

    file: str
    package: str | None
    nodes: list[tuple[str, str]] = field(default_factory=list)
    packages: list[str] = field(default_factory=list)


def file_needs(plan: Plan) -> list[FileNeeds]:
    """Return what each file of a plan needs, in the order in which the files were read."""
    needs = {file: FileNeeds(file, owner(file)) for file in plan.files}
    for node in sorted([*plan.nodes, *plan.tests], key=lambda node: node.line):
        if node.file in needs:
            _append(needs[node.file].nodes, (node.package, node.type))
            _append(needs[node.file].packages, node.package)
    for include in plan.includes:
        package = owner(include.included)
        if package is not None and include.file in needs and package != needs[include.file].package:
            _append(needs[include.file].packages, package)
    return list(needs.values())


def _append(items: list, item: object) -> None:  # type: ignore[type-arg]
    if item not in items:
        items.append(item)


def owner(file: str) -> str | None:
    """Return the package that a file belongs to, None if it is in none."""
    folder, name = package_of(Path(file))
    return name if _manifest(folder) is not None else None


def undeclared(needs: Iterable[FileNeeds], *, test_depends: bool = False) -> dict[str, list[str]]:
    """Return, for each package, the packages that its files need and its ``package.xml`` does not name.

    Args:
        needs: what the files need.
        test_depends: whether what is needed for tests only counts as named, too.

    Raises:
        LaunchError: a package.xml cannot be read.
    """
    missing: dict[str, list[str]] = {}
    for each in needs:
        if each.package is None:
            continue
        found = missing.setdefault(each.package, [])
        declared = {each.package, *declared_depends(package_of(Path(each.file))[0], test_depends=test_depends)}
        found += [package for package in each.packages if package not in declared and package not in found]
    return missing


def declared_depends(folder: Path, *, test_depends: bool = False) -> list[str]:
    """Return the packages that a package's ``package.xml`` or ``manifest.xml`` says it needs when it runs.

    Args:
        folder: of the package.
        test_depends: add those that its tests need.

    Raises:
        LaunchError: the file cannot be read.
    """
    # Imported only where it is needed; it has no stubs.
    from defusedxml.ElementTree import ParseError, fromstring  # type: ignore[import-untyped] # noqa: PLC0415

    path = _manifest(folder)
    if path is None:
        return []
    try:
        root = fromstring(path.read_bytes())
    except (OSError, ValueError, ParseError) as error:
        raise LaunchError(f"cannot read {path}: {error}") from error
    tags = [*_DECLARING, *(["test_depend"] if test_depends else [])]
    names = [child.get("package") or child.text or "" for tag in tags for child in root.findall(tag)]
    return [name.strip() for name in names]


def _manifest(folder: Path) -> Path | None:
    return next((path for name in ("package.xml", "manifest.xml") if (path := folder / name).is_file()), None)
