"""``pyros1 pkg create``: a new package; also as catkin_create_pkg and roscreate-pkg (L185, L204)."""

from __future__ import annotations

import os
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.packages_here import add_packages_here
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.argparsing import add_parts, make_parser
from pyros1.finding.crawl import all_packages
from pyros1.finding.create import CreateError, create, name_problem
from pyros1.finding.library import SHIPPED
from pyros1.finding.new_package import NewPackage
from pyros1.guide.catalogue import CATALOGUE, FACES, ExampleError, builds_with, example, gather, tries

_STOCK = ("catkin_create_pkg", "roscreate-pkg")
_WIDTH = 16  # columns for an example's name


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Create a package.

    Returns:
        The exit code: if the package could not be created 1, or 2 under the stock tools' names.
    """
    if options.list_examples:
        for each in CATALOGUE:
            print(f"{each.name:<{_WIDTH}}{each.about}{'' if each.faces == FACES else f' ({each.faces[0]} only)'}")
        return 0
    called = _called()
    stock = called in _STOCK
    problem = name_problem(options.name)
    if problem and not stock:
        print(f"ERROR: '{options.name}' is not a valid package name: {problem}", file=sys.stderr)
        return 1
    if problem:
        print(f"WARNING: '{options.name}' is not a good package name: {problem}", file=sys.stderr)
    try:
        examples = [example(name, options.face) for name in dict.fromkeys(options.example or ())]
    except ExampleError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    if examples and (options.meta or options.no_examples):
        why = "a metapackage has no files" if options.meta else "--no-examples excludes it"
        print(f"ERROR: --example cannot be used here: {why}", file=sys.stderr)
        return 1
    needs = [requirement for each in examples for requirement in each.needs(options.face)]
    package = NewPackage(
        options.name,
        depends=[*options.dependencies, *(requirement for requirement in needs if builds_with(requirement))],
        runs=[requirement for requirement in needs if not builds_with(requirement)],
        system=options.sys_deps or (),
        boost=options.boost_comps or (),
        version=options.pkg_version,
        description=options.description or "",
        licenses=options.license or (),
        authors=options.author or (),
        maintainers=options.maintainer or (),
        meta=options.meta,
        examples=not (stock or options.no_examples or examples),
        files=gather(examples, options.face, options.name) if examples else {},
    )
    known = {found.name: found.folder for found in reversed(all_packages(os.environ))}
    try:
        made = create(package, Path.cwd())
    except CreateError as error:
        print(f"{called if stock else 'ERROR'}: {error}", file=sys.stderr)
        return 2 if stock else 1
    _warn(options.name, options.dependencies, known)
    if stock:
        _print_as_stock(package, made)
    else:
        _print_created(package, made, tries(examples, package.name) if examples else _minimal(package))
    return 0


def _called() -> str:
    return os.path.basename(sys.argv[0]) if sys.argv else ""


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    called = _called()
    stock = called in _STOCK
    words = invocation.argv[1:]
    if "--list-examples" in words and not stock:
        return Namespace(list_examples=True), []
    tool = Invocation("pkg", called if stock else "", words, with_verb=False)
    parser = make_parser(tool, verb)
    if stock:
        parser.prog = called
    add_parts(parser, tool, *verb.arguments, *(option for option in verb.options if not (option.own and stock)))
    default_options = Namespace(example=None, face=FACES[0], no_examples=False, list_examples=False)
    return (
        parser.parse_args(words, default_options) if stock else parser.parse_intermixed_args(words, default_options)
    ), []


VERB = Verb(
    "create",
    "create a package",
    Option(
        "-e", "--example", action="append", own=True,
        help="an example to use instead of the minimal ones; may be repeated",
    ),
    Option(
        "--face", choices=FACES, default=FACES[0], own=True,
        help="the API that the examples use: node (pyros1.Node, the default) or rospy",
    ),
    Flag("--list-examples", help="list the examples and exit", own=True),
    Flag("--no-examples", help="do not add example nodes, message and launch file", own=True),
    Flag("--meta", help="create a metapackage"),
    Option("-s", "--sys-deps", nargs="*", help="system dependencies"),
    Option("-b", "--boost-comps", nargs="*", help="Boost components"),
    Option("-V", "--pkg_version", default="0.0.0", help="initial version"),
    Option("-D", "--description", help="description"),
    Option("-l", "--license", action="append", help="licence, for example BSD"),
    Option("-a", "--author", action="append", help="an author; may be given several times"),
    Option("-m", "--maintainer", action="append", help="a maintainer, as 'Name <address>'"),
    Option("--rosdistro", help="accepted for compatibility; package.xml is the same for all distributions"),
    Argument("name", help="The name for the package"),
    Argument("dependencies", "package", many=True, optional=True, help="packages that it depends on"),
    description="Creates a new package",
    examples=[
        ("my_robot std_msgs", "with example nodes, a message and a launch file, ready to run"),
        ("my_robot --example service --example timer", "with these examples, ready to run"),
        ("my_robot --example launch --face rospy", "with an example that uses rospy"),
        ("--list-examples", "list the available examples"),
        ("my_robot --no-examples roscpp", "package.xml and CMakeLists.txt only"),
    ],
    stock="catkin_create_pkg",
    parse=_parse,
    run=run,
)  # fmt: skip


def _warn(package: str, depends: Sequence[str], known: dict[str, str]) -> None:
    """Warn about dependencies that are not installed, and about another package of the same name."""
    types = set(os.listdir(SHIPPED))
    for name in depends:
        if name not in known and name not in types:
            hint = did_you_mean(name, {*known, *types})
            print(
                f"WARNING: package '{name}' is not on this machine{hint}; the dependency was added anyway",
                file=sys.stderr,
            )
    other = known.get(package)
    if other is not None:
        print(
            f"WARNING: there is another package '{package}' in {other}: {_preferred_folder(package, other)}",
            file=sys.stderr,
        )


def _preferred_folder(package: str, other: str) -> str:
    """Return a text about which of two packages of one name is used: the new one in this folder, or another one."""
    here = str(Path.cwd())
    found = _found_from_here(package)
    if found != os.path.join(here, package):
        return f"{'that one' if found == other else found} is used, which comes first in ROS_PACKAGE_PATH"
    roots = [part for part in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
    if any(os.path.join(here, "").startswith(os.path.join(os.path.abspath(root), "")) for root in roots):
        return "the new one is used, which comes first in ROS_PACKAGE_PATH"
    return (
        "the new one is used in this folder and below, and that one elsewhere, until you set "
        f"ROS_PACKAGE_PATH={here}:$ROS_PACKAGE_PATH"
    )


def _found_from_here(package: str) -> str | None:
    """Return the folder of the package with this name that commands use in the current folder."""
    environ = dict(os.environ)
    add_packages_here(environ)
    return next((each.folder for each in all_packages(environ) if each.name == package), None)


def _print_as_stock(package: NewPackage, made: list[str]) -> None:
    for name in made:
        print(f"Created {'folder' if name.endswith('/') else 'file'} {name.rstrip('/')}")
    folder = Path.cwd() / package.name
    print(f"Successfully created files in {folder}. Please adjust the values in package.xml.")


def _minimal(package: NewPackage) -> list[str]:
    """Return the commands that show what the minimal examples do, if the package has them."""
    words = ["launch {} minimal.launch", "run {} minimal_publisher", "msg show {}/Measurement"]
    return [f"pyros1 {line.format(package.name)}" for line in words if package.examples and not package.meta]


def _print_created(package: NewPackage, made: list[str], commands: list[str]) -> None:
    for name in made:
        print(f"created {name}")
    if commands:
        print("\nTry it:")
        for command in commands:
            print(f"  {command}")
    here = str(Path.cwd())
    if _found_from_here(package.name) != str(Path.cwd() / package.name):
        print(f"\nTo make the package known: export ROS_PACKAGE_PATH={here}:$ROS_PACKAGE_PATH")
        return
    print("\npyros1 finds the package from this folder and from inside it. To find it from elsewhere:")
    print(f"  export ROS_PACKAGE_PATH={here}:$ROS_PACKAGE_PATH")
