"""Finds the packages that launch files need, and any of them that ``package.xml`` does not declare (L174, L175)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from pyros1.finding.packages import enclosing_package
from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import Plan

_DEPENDENCY_TAGS = ("depend", "exec_depend", "run_depend")


@dataclass
class FileNeeds:
    """The packages and nodes that one launch file needs.

    Attributes:
        file: path of the file, as it was specified.
        package: the package that contains the file; None if it is in no package.
        nodes: ``(package, executable)`` of the nodes and tests, in order, without duplicates.
        packages: packages of the nodes and tests, and packages of included files other than this file's own package;
            in order, without duplicates.
    """

    file: str
    package: str | None
    nodes: list[tuple[str, str]] = field(default_factory=list)
    packages: list[str] = field(default_factory=list)


def file_needs(plan: Plan) -> list[FileNeeds]:
    """Return the packages and nodes that each file in a plan from `load_plan` needs, in reading order."""
    needs = {file: FileNeeds(file, package_containing(file)) for file in plan.files}
    for node in sorted([*plan.nodes, *plan.tests], key=lambda node: node.line):
        _append(needs[node.file].nodes, (node.package, node.type))
        _append(needs[node.file].packages, node.package)
    for include in plan.includes:
        package = package_containing(include.included)
        if package is not None and package != needs[include.file].package:
            _append(needs[include.file].packages, package)
    return list(needs.values())


def _append(items: list, item: object) -> None:  # type: ignore[type-arg]
    if item not in items:
        items.append(item)


def package_containing(file: str) -> str | None:
    """Return the name of the package that contains a file; None if no package does."""
    folder, name = enclosing_package(Path(file))
    return name if _manifest(folder) is not None else None


def find_undeclared(needs: Iterable[FileNeeds], *, test_depends: bool = False) -> dict[str, list[str]]:
    """Return, for each package, the packages that its files need but its ``package.xml`` does not declare.

    Args:
        needs: the needs of each file, from `file_needs`.
        test_depends: whether ``<test_depend>`` is accepted as a declaration.

    Raises:
        LaunchError: a package.xml cannot be read.
    """
    undeclared_by_package: dict[str, list[str]] = {}
    for entry in needs:
        if entry.package is None:
            continue
        undeclared = undeclared_by_package.setdefault(entry.package, [])
        declared = declared_depends(enclosing_package(Path(entry.file))[0], test_depends=test_depends)
        ignored = {entry.package, *declared, *undeclared}
        undeclared += [package for package in entry.packages if package not in ignored]
    return undeclared_by_package


def declared_depends(folder: Path, *, test_depends: bool = False) -> list[str]:
    """Return the runtime dependencies in a package's ``package.xml`` or ``manifest.xml``.

    Args:
        folder: the package's folder.
        test_depends: whether to include the dependencies in ``<test_depend>``.

    Raises:
        LaunchError: the file cannot be read.
    """
    # Imported only where needed. The package has no stubs.
    from defusedxml.ElementTree import ParseError, fromstring  # type: ignore[import-untyped] # noqa: PLC0415

    path = _manifest(folder)
    if path is None:
        return []
    try:
        root = fromstring(path.read_bytes())
    except (OSError, ValueError, LookupError, ParseError) as error:  # LookupError: an unknown encoding
        raise LaunchError(f"cannot read {path}: {error}") from error
    tags = [*_DEPENDENCY_TAGS, *(["test_depend"] if test_depends else [])]
    names = [child.get("package") or child.text or "" for tag in tags for child in root.findall(tag)]
    return [name.strip() for name in names]


def _manifest(folder: Path) -> Path | None:
    return next((path for name in ("package.xml", "manifest.xml") if (path := folder / name).is_file()), None)
