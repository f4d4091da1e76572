"""What launch files depend on."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from pyros1.drop_in.commands import main as _main
from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.depends import FileNeeds, file_needs, owner, undeclared
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.scope import ArgNotSetError
from pyros1.launch.reading.words import parse_arguments
from pyros1.launch.reading.world import make_resources

NAME = "roslaunch-deps"


class RoslaunchDepsException(Exception):
    """A launch file cannot be read."""


class RoslaunchDeps:
    """What one launch file needs.

    Attributes:
        nodes: package and program of each node and test.
        includes: the files that it includes.
        pkgs: the packages of all these.
    """

    def __init__(
        self,
        nodes: list[tuple[str, str]] | None = None,
        includes: list[str] | None = None,
        pkgs: list[str] | None = None,
    ) -> None:
        self.nodes = nodes or []
        self.includes = includes or []
        self.pkgs = pkgs or []

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RoslaunchDeps) and all(
            set(mine) == set(theirs)
            for mine, theirs in ((self.nodes, other.nodes), (self.includes, other.includes), (self.pkgs, other.pkgs))
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"nodes: {self.nodes}\nincludes: {self.includes}\npkgs: {self.pkgs}"


def rl_file_deps(file_deps: dict[str, RoslaunchDeps], launch_file: str, verbose: bool = False) -> None:
    """Add what a launch file and those that it includes need.

    Args:
        file_deps: is filled, by file.
        launch_file: its path.
        verbose: print what is read.

    Raises:
        RoslaunchDepsException: a file cannot be read, or an argument has no value.
    """
    parse_launch(launch_file, file_deps, verbose)


def parse_launch(launch_file: str, file_deps: dict[str, RoslaunchDeps], verbose: bool) -> None:
    """Do what `rl_file_deps` does."""
    resources = replace(make_resources(), run_command=lambda _: "", read_bytes=_if_there(make_resources().read_bytes))
    try:
        plan = load_plan([launch_file], parse_arguments(sys.argv), resources)
    except ArgNotSetError as error:
        raise RoslaunchDepsException(f"No value for arg: {error}") from error
    except LaunchError as error:
        raise RoslaunchDepsException(str(error)) from error
    for needs in file_needs(plan):
        if verbose:
            print(f"processing {'' if needs.file == launch_file else 'included '}launch {needs.file}")
        includes = list(dict.fromkeys(each.included for each in plan.includes if each.file == needs.file))
        file_deps[needs.file] = RoslaunchDeps(needs.nodes, includes, needs.packages)


def _if_there(read: Callable[[str], bytes]) -> Callable[[str], bytes]:
    """Return a function that reads files and treats missing ones as empty, since they only contain parameters."""

    def read_bytes(path: str) -> bytes:
        try:
            return read(path)
        except FileNotFoundError:
            return b""

    return read_bytes


def roslaunch_deps(
    files: Iterable[str], verbose: bool = False, use_test_depends: bool = False, ignore_unset_args: bool = False
) -> tuple[str | None, dict[str, RoslaunchDeps], dict[str, set[str]]]:
    """Return what launch files of one package need.

    Args:
        files: their paths.
        verbose: print what is read.
        use_test_depends: whether ``<test_depend>`` counts as a declaration.
        ignore_unset_args: leave out files whose arguments have no values.

    Returns:
        The package, what `rl_file_deps` fills, and the packages that are not declared, by package.

    Raises:
        RoslaunchDepsException: a file cannot be read, or is in another package than the first.
    """
    base: str | None = None
    file_deps: dict[str, RoslaunchDeps] = {}
    for file in files:
        if not os.path.exists(file):
            raise RoslaunchDepsException(f"roslaunch file [{file}] does not exist")
        package = owner(file)
        if base and package != base:
            raise RoslaunchDepsException(f"roslaunch files must be in the same package: {base} vs. {package}")
        base = package
        try:
            rl_file_deps(file_deps, file, verbose)
        except RoslaunchDepsException as error:
            if not (ignore_unset_args and isinstance(error.__cause__, ArgNotSetError)):
                raise
    return base, file_deps, calculate_missing(base, {}, file_deps, use_test_depends)


def calculate_missing(
    base_pkg: str | None,
    missing: dict[str, set[str]],
    file_deps: dict[str, RoslaunchDeps],
    use_test_depends: bool = False,
) -> dict[str, set[str]]:
    """Add, by package, the packages that files need but their package does not declare, and return the same."""
    needs = [FileNeeds(file, owner(file), deps.nodes, deps.pkgs) for file, deps in file_deps.items()]
    for each in needs:
        if each.package is None:
            print(f"ERROR: cannot determine package for [{each.file}]", file=sys.stderr)
    for package, names in undeclared(needs, test_depends=use_test_depends).items():
        missing.setdefault(package, set()).update(names)
    return missing


def print_deps(base_pkg: Any, file_deps: dict[str, RoslaunchDeps], verbose: bool) -> None:
    """Print the packages that files need in one line; with ``verbose`` first which file needs which."""
    if verbose:
        for file, deps in file_deps.items():
            for package, kind in deps.nodes:
                print(f"{package} [{package}/{kind}]")
            print(f"{owner(file)} [{file}]")
        print("-" * 80)
    print(" ".join(sorted({package for deps in file_deps.values() for package in deps.pkgs})))


def fullusage() -> None:
    """Print how the command is called."""
    print(f"Usage:\n\t{NAME} [options] <file-or-package>\n")


def roslaunch_deps_main(argv: list[str] = sys.argv) -> None:
    """Do what the command roslaunch-deps does; exit with its exit code if it fails."""
    _main("roslaunch", [argv[0], "--deps", *argv[1:]])
