"""``pkg depends`` and similar verbs, ``rosdep``, ``rosdep0`` and ``profile``: print what packages depend on (L182)."""

from __future__ import annotations

import os

from pyros1.cli.commands.pkg._dependencies import check_known, packages_and_name
from pyros1.cli.commands.pkg._rospack import PkgError, Request, make_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Flag, Option, RunFunction, Verb
from pyros1.finding.crawl import measure_folders, search_folders
from pyros1.ground.errors import PackageNotFoundError


def _print_all_dependencies(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, package_name = packages_and_name(request)
    request.print_names(packages.dependencies(package_name))


def _print_direct_dependencies(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, package_name = packages_and_name(request)
    request.print_names(packages.direct_dependencies(package_name))


def _print_dependents(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, package_name = packages_and_name(request)
    if package_name not in packages.by_name:
        raise PackageNotFoundError(package_name)
    request.print_names(
        packages.dependents(package_name) if request.verb.endswith("1") else packages.all_dependents(package_name)
    )


def _print_tree(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, package_name = packages_and_name(request)
    check_known(packages, package_name)
    for level, package in packages.tree(package_name):
        print("  " * level + package)


def _print_chains(invocation: Invocation, request: Request, args: list[str]) -> None:
    if not request.options.get("target"):
        raise PkgError("no package or target given")
    packages, package_name = packages_and_name(request)
    target = request.options["target"]
    for package in (package_name, target):
        check_known(packages, package)
    print(f"Dependency chains from {package_name} to {target}:")
    for chain in packages.chains(package_name, target):
        print(f"* {' -> '.join(chain)} ")


def _print_manifests(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, package_name = packages_and_name(request)
    if package_name not in packages.by_name:
        print()  # like rospack, which prints an empty line before the error
        check_known(packages, package_name)
    found_packages = [packages.find(package) for package in packages.dependencies(package_name)]
    print(" ".join(os.path.join(package.folder, package.manifest) for package in found_packages))


def _print_profile(invocation: Invocation, request: Request, args: list[str]) -> None:
    folder_timings = measure_folders(search_folders(os.environ))
    if "zombie-only" in request.options:
        for _, folder, has_manifest in folder_timings:
            if not has_manifest:
                print(folder)
        return
    length = request.options.get("length", "20")
    total = sum(seconds for seconds, folder, _ in folder_timings if folder in dict(search_folders(os.environ)))
    print(f"Full tree crawl took {total:.6f} seconds.")
    print("Directories marked with (*) contain no manifest.  You may")
    print("want to delete these directories.")
    print("To get just of list of directories without manifests,")
    print("re-run the profile with --zombie-only")
    print("-" * 61)
    for seconds, folder, has_manifest in folder_timings[: int(length) if length.lstrip("-").isdigit() else 0]:
        print(f"{seconds:.6f} {' ' if has_manifest else '*'} {folder}")


def _print_system_packages(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the system packages that a package and its dependencies need."""
    packages, package_name = packages_and_name(request)
    check_known(packages, package_name)
    package_names = (
        [package_name] if request.verb == "rosdep0" else [*packages.dependencies(package_name), package_name]
    )
    is_catkin = packages.manifest(package_name).is_catkin
    rosdep_keys: set[str] = set()
    for package in package_names:
        manifest = packages.manifest(package)
        rosdep_keys.update(manifest.system_keys)
        if is_catkin:  # rosbuild packages name rosdep keys only in manifest.xml
            rosdep_keys.update(key for _, key in manifest.depends)
    request.print_names(
        sorted(rosdep_keys) if "json" in request.options else [f"name: {key}" for key in sorted(rosdep_keys)]
    )


_PACKAGE_ARGUMENT = Argument("package", "package", optional=True)


def _make_verb(
    name: str, run: RunFunction, example: str, *options: Option, target: str = "", lists_alias: bool = True
) -> Verb:
    """Return the `Verb` for a command about dependencies.

    Args:
        name: the name of the verb. In its alias, ``deps`` replaces ``depends``.
        run: the function that runs the verb.
        example: the description of the example.
        options: the options.
        target: the option ``--target`` as shown in the list of verbs; empty if the verb has no such option.
        lists_alias: whether the list of verbs shows the alias.
    """
    alias = name.replace("depends", "deps")
    about = f"{name}{target}" if target else f"{name:17}"
    about += " [package]" + f" (alias: {alias})" * lists_alias
    examples = [(f"{'--target=std_msgs ' * bool(target)}roscpp", example)]
    return make_verb(name, about, *options, _PACKAGE_ARGUMENT, aliases=[alias], run=run, examples=examples)


VERBS = [
    _make_verb("depends", _print_all_dependencies, "list all dependencies in build order", JSON_FLAG),
    _make_verb("depends-indent", _print_tree, "print dependencies as a tree"),
    _make_verb("depends-manifests", _print_manifests, "list the manifests of all dependencies"),
    _make_verb(
        "depends-on", _print_dependents, "list all packages that depend on roscpp", JSON_FLAG, lists_alias=False
    ),
    _make_verb(
        "depends-on1", _print_dependents, "list packages that depend on roscpp directly", JSON_FLAG, lists_alias=False
    ),
    _make_verb("depends1", _print_direct_dependencies, "list direct dependencies", JSON_FLAG),
    _make_verb(
        "depends-why",
        _print_chains,
        "print every chain of dependencies from roscpp to std_msgs",
        Option("--target", metavar="TARGET", help="the dependency to explain"),
        target=" --target=<target>",
    ),
    make_verb(
        "rosdep",
        "rosdep  [package] (alias: rosdeps)",
        JSON_FLAG,
        _PACKAGE_ARGUMENT,
        aliases=["rosdeps"],
        run=_print_system_packages,
        examples=[("roscpp", "list system packages that roscpp and its dependencies need")],
    ),
    make_verb(
        "rosdep0",
        "rosdep0 [package] (alias: rosdeps0)",
        JSON_FLAG,
        _PACKAGE_ARGUMENT,
        aliases=["rosdeps0"],
        run=_print_system_packages,
        examples=[("roscpp", "list system packages that roscpp itself needs")],
    ),
    make_verb(
        "profile",
        "profile [--length=<length>] [--zombie-only]",
        Option("--length", metavar="LENGTH", help="number of folders"),
        Flag("--zombie-only", help="print only folders without a manifest"),
        run=_print_profile,
        examples=[
            ("--length=5", "list the folders that take longest to search"),
            ("--zombie-only", "list folders without a package"),
        ],
    ),
]
