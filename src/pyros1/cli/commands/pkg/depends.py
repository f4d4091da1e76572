"""``pkg depends`` and the verbs like it, ``rosdep``, ``rosdep0`` and ``profile``: what packages need (L182)."""

from __future__ import annotations

import os

from pyros1.cli.commands.pkg._graph import check_known, graph
from pyros1.cli.commands.pkg._rospack import PkgError, Request, pack_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument, Flag, Option, Run, Verb
from pyros1.finding.crawl import profile, search_folders
from pyros1.ground.errors import PackageNotFoundError


def _all_needs(invocation: Invocation, request: Request, args: list[str]) -> None:
    known, name = graph(request)
    request.print_names(known.needs(name))


def _direct_needs(invocation: Invocation, request: Request, args: list[str]) -> None:
    known, name = graph(request)
    request.print_names(known.direct(name))


def _needed_by(invocation: Invocation, request: Request, args: list[str]) -> None:
    known, name = graph(request)
    if name not in known.by_name:
        raise PackageNotFoundError(name)
    request.print_names(known.needed_by(name) if request.verb.endswith("1") else known.all_needed_by(name))


def _tree(invocation: Invocation, request: Request, args: list[str]) -> None:
    known, name = graph(request)
    check_known(known, name)
    for level, each in known.tree(name):
        print("  " * level + each)


def _why(invocation: Invocation, request: Request, args: list[str]) -> None:
    if not request.options.get("target"):
        raise PkgError("no package or target given")
    known, name = graph(request)
    target = request.options["target"]
    for each in (name, target):
        check_known(known, each)
    print(f"Dependency chains from {name} to {target}:")
    for chain in known.chains(name, target):
        print(f"* {' -> '.join(chain)} ")


def _manifests(invocation: Invocation, request: Request, args: list[str]) -> None:
    known, name = graph(request)
    if name not in known.by_name:
        print()  # like stock, which prints the line even without files
        check_known(known, name)
    files = [os.path.join(known.find(each).folder, known.find(each).manifest) for each in known.needs(name)]
    print(" ".join(files))


def _profile(invocation: Invocation, request: Request, args: list[str]) -> None:
    rows = profile(search_folders(os.environ))
    if "zombie-only" in request.options:
        for _, folder, holds in rows:
            if not holds:
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
    for seconds, folder, holds in rows[: int(length) if length.lstrip("-").isdigit() else 0]:
        print(f"{seconds:.6f} {' ' if holds else '*'} {folder}")


def _rosdep(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the system packages that a package and its dependencies need."""
    known, name = graph(request)
    check_known(known, name)
    names = [name] if request.verb == "rosdep0" else [*known.needs(name), name]
    catkin = known.manifest(name).catkin
    keys: set[str] = set()
    for each in names:
        manifest = known.manifest(each)
        keys.update(manifest.system)
        if catkin:  # rosbuild packages name rosdep keys only in manifest.xml
            keys.update(key for _, key in manifest.depends)
    request.print_names(sorted(keys) if "json" in request.options else [f"name: {key}" for key in sorted(keys)])


_PACKAGE = Argument("package", "package", optional=True)


def _verb(name: str, run: Run, example: str, *options: Option, target: str = "", noted: bool = True) -> Verb:
    """Return the record of a verb about dependencies; ``noted``: whether the list of verbs mentions its alias."""
    alias = name.replace("depends", "deps")
    about = f"{name}{target}" if target else f"{name:17}"
    about += " [package]" + f" (alias: {alias})" * noted
    examples = [(f"{'--target=std_msgs ' * bool(target)}roscpp", example)]
    return pack_verb(name, about, *options, _PACKAGE, aliases=[alias], run=run, examples=examples)


VERBS = [
    _verb("depends", _all_needs, "all dependencies, in build order", JSON),
    _verb("depends-indent", _tree, "dependencies as a tree"),
    _verb("depends-manifests", _manifests, "the manifests of all dependencies"),
    _verb("depends-on", _needed_by, "all packages that depend on it", JSON, noted=False),
    _verb("depends-on1", _needed_by, "packages that depend on it directly", JSON, noted=False),
    _verb("depends1", _direct_needs, "direct dependencies", JSON),
    _verb(
        "depends-why",
        _why,
        "every chain of dependencies between the two",
        Option("--target", metavar="TARGET", help="the dependency"),
        target=" --target=<target>",
    ),
    pack_verb(
        "rosdep",
        "rosdep  [package] (alias: rosdeps)",
        JSON,
        _PACKAGE,
        aliases=["rosdeps"],
        run=_rosdep,
        examples=[("roscpp", "system packages for it and its dependencies")],
    ),
    pack_verb(
        "rosdep0",
        "rosdep0 [package] (alias: rosdeps0)",
        JSON,
        _PACKAGE,
        aliases=["rosdeps0"],
        run=_rosdep,
        examples=[("roscpp", "system packages for this package only")],
    ),
    pack_verb(
        "profile",
        "profile [--length=<length>] [--zombie-only]",
        Option("--length", metavar="LENGTH", help="number of folders"),
        Flag("--zombie-only", help="print only folders without a manifest"),
        run=_profile,
        examples=[
            ("--length=5", "the folders that take longest to search"),
            ("--zombie-only", "folders without a package"),
        ],
    ),
]
