"""``msg list``, ``package`` and ``packages``: print the names of types and packages (L88, L89)."""

from __future__ import annotations

import os
from functools import partial
from typing import Any

from pyros1.cli.failures import EX_USAGE, UsageError, did_you_mean, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.definitions import JSON_LIST_FLAG, MESSAGE_KIND, DefinitionKind, library, read_name_from_stdin
from pyros1.cli.shared.printing import print_json


def _print_all_types(kind: DefinitionKind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the types in all packages."""
    names = [name for package in library().packages() for name in kind.type_names(library(), package)]
    if options.json:
        print_json(names)
    elif names:
        print(*names, sep="\n")


def _print_types_in_package(kind: DefinitionKind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the types in a package."""
    if len(args) > 1:
        raise UsageError(f"you may only specify one {kind.word} type")  # as in stock ROS, although it is a package
    package_name = args[0] if args else read_name_from_stdin()
    if not library().has_package(package_name):
        from pyros1.finding.packages import PackageIndex  # noqa: PLC0415 - only needed after a failure

        packages = PackageIndex(os.environ).paths()
        if package_name not in packages:
            fail(
                f"Invalid package: {package_name}{did_you_mean(package_name, {*packages, *library().packages()})}",
                EX_USAGE,
            )
    _print_names(kind.type_names(library(), package_name), options)


def _print_packages(kind: DefinitionKind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the packages that contain message or service types."""
    _print_names([name for name in library().packages() if kind.type_names(library(), name)], options)


def _print_names(names: list[str], options: Any) -> None:
    if options.json:
        print_json(names)
    else:
        print(*names, sep=" " if options.single_line else "\n")


def make_verbs(kind: DefinitionKind, example_package: str) -> list[Verb]:
    """Return the three verbs for messages or services.

    Args:
        kind: messages or services.
        example_package: a package that contains such types, for the examples.
    """
    return [
        Verb(
            "list",
            f"List all {kind.word}s",
            JSON_LIST_FLAG,
            usage="",
            examples=[("", "list all types"), ("--json", "print JSON for programs")],
            run=partial(_print_all_types, kind),
        ),
        Verb(
            "package",
            f"List {kind.word}s in a package",
            Flag("-s", dest="single_line", help=f"list all {kind.extension}s on a single line"),
            JSON_LIST_FLAG,
            Argument("package", "package"),
            usage="<package>",
            examples=[(example_package, "list the types of a package")],
            run=partial(_print_types_in_package, kind),
        ),
        Verb(
            "packages",
            f"List packages that contain {kind.word}s",
            Flag("-s", dest="single_line", help="list all packages on a single line"),
            JSON_LIST_FLAG,
            usage="",
            examples=[("", f"list packages that contain {kind.word}s")],
            run=partial(_print_packages, kind),
        ),
    ]


VERBS = make_verbs(MESSAGE_KIND, "sensor_msgs")
