"""The verbs of ``pkg`` and ``stack`` about dependencies, which read manifests (L182, L183)."""

from __future__ import annotations

import os

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument, Flag, Option, Run, Verb
from pyros1.cli.shared.rospack.tool import PkgError, Request, pack_verb, packages
from pyros1.finding.crawl import places, profile
from pyros1.finding.dependencies import Packages
from pyros1.finding.manifest import Manifest
from pyros1.ground.errors import PackageNotFoundError

DEPS_ONLY = Flag("--deps-only", help="leave out the package itself")


def graph(request: Request) -> tuple[Packages, str]:
    """Return all packages, and the name of the package that was given."""
    name = request.package()
    return packages(request.stock), name


def must_be(known: Packages, name: str) -> None:
    """Raise an error if a package is unknown."""
    if name not in known.by_name:
        raise PkgError(f"package '{name}' not found")


def chosen(request: Request, known: Packages, name: str) -> list[Manifest]:
    """Return the manifests of a package and its dependencies, or of these only, as the options say."""
    names = [*known.needs_first(name)]
    if "deps-only" not in request.options:
        names.insert(0, name)
    return [known.manifest(each) for each in names]


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
    must_be(known, name)
    for level, each in known.tree(name):
        print("  " * level + each)


def _why(invocation: Invocation, request: Request, args: list[str]) -> None:
    if not request.options.get("target"):
        raise PkgError(f"no {request.unit} or target given")
    known, name = graph(request)
    target = request.options["target"]
    for each in (name, target):
        must_be(known, each)
    print(f"Dependency chains from {name} to {target}:")
    for chain in known.chains(name, target):
        print(f"* {' -> '.join(chain)} ")


def _manifests(invocation: Invocation, request: Request, args: list[str]) -> None:
    known, name = graph(request)
    if name not in known.by_name:
        print()  # as stock, which prints the line even without files
        must_be(known, name)
    files = [os.path.join(known.find(each).folder, known.find(each).manifest) for each in known.needs(name)]
    print(" ".join(files))


def _profile(invocation: Invocation, request: Request, args: list[str]) -> None:
    rows = profile(places(os.environ))
    if "zombie-only" in request.options:
        for _, folder, holds in rows:
            if not holds:
                print(folder)
        return
    length = request.options.get("length", "20")
    total = sum(seconds for seconds, folder, _ in rows if folder in dict(places(os.environ)))
    print(f"Full tree crawl took {total:.6f} seconds.")
    print("Directories marked with (*) contain no manifest.  You may")
    print("want to delete these directories.")
    print("To get just of list of directories without manifests,")
    print("re-run the profile with --zombie-only")
    print("-" * 61)
    for seconds, folder, holds in rows[: int(length) if length.lstrip("-").isdigit() else 0]:
        print(f"{seconds:.6f} {' ' if holds else '*'} {folder}")


def depends_verbs(unit: str, width: int) -> list[Verb]:
    """Return the records of the verbs about dependencies.

    Args:
        unit: ``package`` or ``stack``.
        width: of the names in the list of verbs.
    """
    package = Argument(unit, "package", optional=True)

    def verb(name: str, run: Run, example: str, *options: Option, target: str = "", noted: bool = True) -> Verb:
        alias = name.replace("depends", "deps")
        about = f"{name}{target}" if target else f"{name:{width}}"
        about += f" [{unit}]" + f" (alias: {alias})" * noted
        examples = [(f"{'--target=std_msgs ' * bool(target)}roscpp", example)]
        return pack_verb(name, about, *options, package, aliases=[alias], run=run, examples=examples)

    return [
        verb("depends", _all_needs, "all dependencies, in build order", JSON),
        verb("depends-indent", _tree, "dependencies as a tree"),
        verb("depends-manifests", _manifests, "the manifests of all dependencies"),
        verb("depends-on", _needed_by, "all packages that depend on it", JSON, noted=False),
        verb("depends-on1", _needed_by, "packages that depend on it directly", JSON, noted=False),
        verb("depends1", _direct_needs, "direct dependencies", JSON),
        verb(
            "depends-why",
            _why,
            "every chain of dependencies between the two",
            Option("--target", metavar="TARGET", help="the dependency"),
            target=" --target=<target>",
        ),
    ]


def profile_verb(about: str) -> Verb:
    """Return the record of ``profile``. `about` is its line in the list of verbs."""
    return pack_verb(
        "profile",
        about,
        Option("--length", metavar="LENGTH", help="number of folders"),
        Flag("--zombie-only", help="print only folders without a manifest"),
        run=_profile,
        examples=[
            ("--length=5", "the folders that take longest to search"),
            ("--zombie-only", "folders without a package"),
        ],
    )
