"""``pyros1 pkg create``: creates a package, like catkin_create_pkg and roscreate-pkg (L185, L204)."""

from __future__ import annotations

import os
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.nearby_packages import add_nearby_packages
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser
from pyros1.finding.crawl import all_packages
from pyros1.finding.create import CreateError, create_package, package_name_problem
from pyros1.finding.library import SHIPPED_DEFINITIONS
from pyros1.finding.new_package import NewPackage
from pyros1.guide.catalogue import (
    APIS,
    CATALOGUE,
    ExampleError,
    collect_files,
    commands_to_try,
    find_example,
    is_build_dependency,
)

_STOCK_TOOLS = ("catkin_create_pkg", "roscreate-pkg")
_NAME_WIDTH = 16  # width of the column of example names


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Create a package.

    Returns:
        The exit code: 0, or after a failure 1 (2 for the stock tools).
    """
    if options.list_examples:
        for entry in CATALOGUE:
            print(f"{entry.name:<{_NAME_WIDTH}}{entry.about}{'' if entry.apis == APIS else f' ({entry.apis[0]} only)'}")
        return 0
    program = _program_name()
    as_stock = program in _STOCK_TOOLS
    problem = package_name_problem(options.name)
    if problem and not as_stock:
        print(f"ERROR: '{options.name}' is not a valid package name: {problem}", file=sys.stderr)
        return 1
    if problem:
        print(f"WARNING: '{options.name}' is not a good package name: {problem}", file=sys.stderr)
    try:
        examples = [find_example(name, options.api) for name in dict.fromkeys(options.example or ())]
    except ExampleError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    if examples and (options.meta or options.no_examples):
        reason = "a metapackage has no files" if options.meta else "--no-examples excludes it"
        print(f"ERROR: --example cannot be used here: {reason}", file=sys.stderr)
        return 1
    example_dependencies = [dependency for example in examples for dependency in example.dependencies(options.api)]
    package = NewPackage(
        options.name,
        depends=[
            *options.dependencies,
            *(dependency for dependency in example_dependencies if is_build_dependency(dependency)),
        ],
        run_depends=[dependency for dependency in example_dependencies if not is_build_dependency(dependency)],
        system_depends=options.sys_deps or (),
        boost=options.boost_comps or (),
        version=options.pkg_version,
        description=options.description or "",
        licenses=options.license or (),
        authors=options.author or (),
        maintainers=options.maintainer or (),
        is_meta=options.meta,
        examples=not (as_stock or options.no_examples or examples),
        files=collect_files(examples, options.api, options.name) if examples else {},
    )
    folders_by_package = {entry.name: entry.folder for entry in reversed(all_packages(os.environ))}
    try:
        created_paths = create_package(package, Path.cwd())
    except CreateError as error:
        print(f"{program if as_stock else 'ERROR'}: {error}", file=sys.stderr)
        return 2 if as_stock else 1
    _warn_about_packages(options.name, options.dependencies, folders_by_package)
    if as_stock:
        _print_as_stock(package, created_paths)
    else:
        _print_created(
            package, created_paths, commands_to_try(examples, package.name) if examples else _minimal_commands(package)
        )
    return 0


def _program_name() -> str:
    return os.path.basename(sys.argv[0]) if sys.argv else ""


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    program = _program_name()
    as_stock = program in _STOCK_TOOLS
    args = invocation.argv[1:]
    if "--list-examples" in args and not as_stock:
        return Namespace(list_examples=True), []
    tool_invocation = Invocation("pkg", program if as_stock else "", args, with_verb=False)
    parser = make_parser(tool_invocation, verb)
    if as_stock:
        parser.prog = program
    add_options_and_arguments(
        parser,
        tool_invocation,
        *verb.arguments,
        *(option for option in verb.options if not (option.pyros1_only and as_stock)),
    )
    default_options = Namespace(example=None, api=APIS[0], no_examples=False, list_examples=False)
    return (
        parser.parse_args(args, default_options) if as_stock else parser.parse_intermixed_args(args, default_options)
    ), []


VERB = Verb(
    "create",
    "create a package",
    Option(
        "-e", "--example", action="append", pyros1_only=True,
        help="an example to use instead of the minimal ones; may be repeated",
    ),
    Option(
        "--face", dest="api", choices=APIS, default=APIS[0], pyros1_only=True,
        help="the API that the examples use: node (pyros1.Node, the default) or rospy",
    ),
    Flag("--list-examples", help="list the examples and exit", pyros1_only=True),
    Flag("--no-examples", help="do not add example nodes, message and launch file", pyros1_only=True),
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
    Argument(
        "dependencies", "package", repeatable=True, optional=True, help="packages that the new package depends on"
    ),
    description="Creates a new package",
    examples=[
        ("my_robot std_msgs", "create a package with example nodes, a message and a launch file, ready to run"),
        ("my_robot --example service --example timer", "create a package with these examples, ready to run"),
        ("my_robot --example launch --face rospy", "create a package with an example that uses rospy"),
        ("--list-examples", "list the available examples"),
        ("my_robot --no-examples roscpp", "create only package.xml and CMakeLists.txt"),
    ],
    stock="catkin_create_pkg",
    parse=_parse,
    run=run,
)  # fmt: skip


def _warn_about_packages(package: str, dependencies: Sequence[str], folders_by_package: dict[str, str]) -> None:
    """Warn about dependencies that are not installed, and about another package with the same name."""
    shipped_packages = set(os.listdir(SHIPPED_DEFINITIONS))
    for name in dependencies:
        if name not in folders_by_package and name not in shipped_packages:
            hint = did_you_mean(name, {*folders_by_package, *shipped_packages})
            print(
                f"WARNING: package '{name}' is not installed on this machine{hint}; the dependency was added anyway",
                file=sys.stderr,
            )
    other_folder = folders_by_package.get(package)
    if other_folder is not None:
        print(
            f"WARNING: there is another package '{package}' in {other_folder}: "
            f"{_preference_text(package, other_folder)}",
            file=sys.stderr,
        )


def _preference_text(package: str, other_folder: str) -> str:
    """Return a sentence that says which of two packages with the same name is used: the new one or the one in
    `other_folder`."""
    current_folder = str(Path.cwd())
    found_folder = _find_from_current_folder(package)
    if found_folder != os.path.join(current_folder, package):
        used_text = "the other one" if found_folder == other_folder else found_folder
        return f"{used_text} is used, because it is first in ROS_PACKAGE_PATH"
    roots = [part for part in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
    if any(os.path.join(current_folder, "").startswith(os.path.join(os.path.abspath(root), "")) for root in roots):
        return "the new one is used, because it is first in ROS_PACKAGE_PATH"
    return (
        "the new one is used in this folder and below, and the other one elsewhere, unless you set "
        f"ROS_PACKAGE_PATH={current_folder}:$ROS_PACKAGE_PATH"
    )


def _find_from_current_folder(package: str) -> str | None:
    """Return the folder of the package that commands find when run in the current folder; None if they find none."""
    environ = dict(os.environ)
    add_nearby_packages(environ)
    return next((entry.folder for entry in all_packages(environ) if entry.name == package), None)


def _print_as_stock(package: NewPackage, created_paths: list[str]) -> None:
    for path in created_paths:
        print(f"Created {'folder' if path.endswith('/') else 'file'} {path.rstrip('/')}")
    folder = Path.cwd() / package.name
    print(f"Successfully created files in {folder}. Please adjust the values in package.xml.")


def _minimal_commands(package: NewPackage) -> list[str]:
    """Return the commands that demonstrate the minimal examples; empty if the package lacks these examples."""
    lines = ["launch {} minimal.launch", "run {} minimal_publisher", "msg show {}/Measurement"]
    return [f"pyros1 {line.format(package.name)}" for line in lines if package.examples and not package.is_meta]


def _print_created(package: NewPackage, created_paths: list[str], commands: list[str]) -> None:
    for path in created_paths:
        print(f"created {path}")
    if commands:
        print("\nTry it:")
        for command in commands:
            print(f"  {command}")
    current_folder = str(Path.cwd())
    if _find_from_current_folder(package.name) != str(Path.cwd() / package.name):
        print(f"\nTo make the package known: export ROS_PACKAGE_PATH={current_folder}:$ROS_PACKAGE_PATH")
        return
    print("\npyros1 finds the package from this folder and from inside the package. To find it from elsewhere:")
    print(f"  export ROS_PACKAGE_PATH={current_folder}:$ROS_PACKAGE_PATH")
