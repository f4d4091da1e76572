"""``pkg depends`` and similar verbs, ``rosdep``, ``rosdep0`` and ``profile``: dependencies of packages (L182)."""

from __future__ import annotations

import os

from pyros1.cli.commands.pkg._graph import check_known, packages_and_name
from pyros1.cli.commands.pkg._rospack import PkgError, Request, make_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Flag, Option, RunFunction, Verb
from pyros1.finding.crawl import profile, search_folders
from pyros1.ground.errors import PackageNotFoundError


def _all_dependencies(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, name = packages_and_name(request)
    request.print_names(packages.dependencies(name))


def _direct_dependencies(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, name = packages_and_name(request)
    request.print_names(packages.direct_dependencies(name))


def _dependents(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, name = packages_and_name(request)
    if name not in packages.by_name:
        raise PackageNotFoundError(name)
    request.print_names(packages.dependents(name) if request.verb.endswith("1") else packages.all_dependents(name))


def _print_tree(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, name = packages_and_name(request)
    check_known(packages, name)
    for level, package in packages.tree(name):
        print("  " * level + package)


def _print_chains(invocation: Invocation, request: Request, args: list[str]) -> None:
    if not request.options.get("target"):
        raise PkgError("no package or target given")
    packages, name = packages_and_name(request)
    target = request.options["target"]
    for package in (name, target):
        check_known(packages, package)
    print(f"Dependency chains from {name} to {target}:")
    for chain in packages.chains(name, target):
        print(f"* {' -> '.join(chain)} ")


def _print_manifests(invocation: Invocation, request: Request, args: list[str]) -> None:
    packages, name = packages_and_name(request)
    if name not in packages.by_name:
        print()  # like stock, which prints an empty line before the error
        check_known(packages, name)
    found_packages = [packages.find(package) for package in packages.dependencies(name)]
    print(" ".join(os.path.join(package.folder, package.manifest) for package in found_packages))


def _print_profile(invocation: Invocation, request: Request, args: list[str]) -> None:
    rows = profile(search_folders(os.environ))
    if "zombie-only" in request.options:
        for _, folder, has_manifest in rows:
            if not has_manifest:
                print(folder)
        return
    length = request.options.get("length", "20")
    total = sum(seconds for seconds, folder, _ in rows if folder in dict(search_folders(os.environ)))
    print(f"Full tree crawl took {total:.6f} seconds.")
    print("Directories marked with (*) contain no manifest.  You may")
    print("want to delete these directories.")
    print("To get just of list of directories without manifests,")
    print("re-run the profile with --zombie-only")
    print("-" * 61)
    for seconds, folder, has_manifest in rows[: int(length) if length.lstrip("-").isdigit() else 0]:
        print(f"{seconds:.6f} {' ' if has_manifest else '*'} {folder}")


def _rosdep(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the system packages that a package and its dependencies need."""
    packages, name = packages_and_name(request)
    check_known(packages, name)
    package_names = [name] if request.verb == "rosdep0" else [*packages.dependencies(name), name]
    catkin = packages.manifest(name).catkin
    keys: set[str] = set()
    for package in package_names:
        manifest = packages.manifest(package)
        keys.update(manifest.system_keys)
        if catkin:  # rosbuild packages name rosdep keys only in manifest.xml
            keys.update(key for _, key in manifest.depends)
    request.print_names(sorted(keys) if "json" in request.options else [f"name: {key}" for key in sorted(keys)])


_PACKAGE = Argument("package", "package", optional=True)


def _make_verb(
    name: str, run: RunFunction, example: str, *options: Option, target: str = "", lists_alias: bool = True
) -> Verb:
    """Return the `Verb` for dependencies. `lists_alias` tells whether the list of verbs mentions its alias."""
    alias = name.replace("depends", "deps")
    about = f"{name}{target}" if target else f"{name:17}"
    about += " [package]" + f" (alias: {alias})" * lists_alias
    examples = [(f"{'--target=std_msgs ' * bool(target)}roscpp", example)]
    return make_verb(name, about, *options, _PACKAGE, aliases=[alias], run=run, examples=examples)


VERBS = [
    _make_verb("depends", _all_dependencies, "list all dependencies in build order", JSON_FLAG),
    _make_verb("depends-indent", _print_tree, "print dependencies as a tree"),
    _make_verb("depends-manifests", _print_manifests, "list the manifests of all dependencies"),
    _make_verb("depends-on", _dependents, "list all packages that depend on it", JSON_FLAG, lists_alias=False),
    _make_verb("depends-on1", _dependents, "list packages that depend on it directly", JSON_FLAG, lists_alias=False),
    _make_verb("depends1", _direct_dependencies, "list direct dependencies", JSON_FLAG),
    _make_verb(
        "depends-why",
        _print_chains,
        "print every chain of dependencies between the two",
        Option("--target", metavar="TARGET", help="the dependency"),
        target=" --target=<target>",
    ),
    make_verb(
        "rosdep",
        "rosdep  [package] (alias: rosdeps)",
        JSON_FLAG,
        _PACKAGE,
        aliases=["rosdeps"],
        run=_rosdep,
        examples=[("roscpp", "list system packages for it and its dependencies")],
    ),
    make_verb(
        "rosdep0",
        "rosdep0 [package] (alias: rosdeps0)",
        JSON_FLAG,
        _PACKAGE,
        aliases=["rosdeps0"],
        run=_rosdep,
        examples=[("roscpp", "list system packages for this package only")],
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
