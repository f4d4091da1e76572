"""The verbs of ``pyros1 pkg`` that read manifests: what packages need, export and come from (L182, L183)."""

from __future__ import annotations

import os
import shlex
import subprocess
from collections.abc import Callable, Iterable

from pyros1.cli.common import print_json
from pyros1.cli.pkg import PkgError, Request, packages
from pyros1.errors import PackageNotFoundError
from pyros1.finding.crawl import places, profile
from pyros1.finding.dependencies import Packages
from pyros1.finding.manifest import Manifest


def _print(request: Request, names: Iterable[str]) -> None:
    if "json" in request.options:
        print_json([*names])
    else:
        print("".join(f"{name}\n" for name in names), end="")


def _graph(request: Request) -> tuple[Packages, str]:
    name = request.package()
    return packages(request.stock), name


def _must_be(known: Packages, name: str, unit: str = "package") -> None:
    if name not in known.by_name:
        raise PkgError(f"{unit} '{name}' not found")


def _all_needs(request: Request) -> None:
    known, name = _graph(request)
    _print(request, known.needs(name))


def _direct_needs(request: Request) -> None:
    known, name = _graph(request)
    _print(request, known.direct(name))


def _needed_by(request: Request) -> None:
    known, name = _graph(request)
    if name not in known.by_name:
        raise PackageNotFoundError(name)
    _print(request, known.needed_by(name) if request.verb.endswith("1") else known.all_needed_by(name))


def _tree(request: Request) -> None:
    known, name = _graph(request)
    _must_be(known, name)
    for level, each in known.tree(name):
        print("  " * level + each)


def _why(request: Request) -> None:
    if not request.options.get("target"):
        raise PkgError(f"no {request.unit} or target given")
    known, name = _graph(request)
    target = request.options["target"]
    for each in (name, target):
        _must_be(known, each)
    print(f"Dependency chains from {name} to {target}:")
    for chain in known.chains(name, target):
        print(f"* {' -> '.join(chain)} ")


def _manifests(request: Request) -> None:
    known, name = _graph(request)
    if name not in known.by_name:
        print()  # as stock: the line that would hold the files comes all the same
        _must_be(known, name)
    files = [os.path.join(known.find(each).folder, known.find(each).manifest) for each in known.needs(name)]
    print(" ".join(files))


def _generated(request: Request) -> None:
    """Print the files that rosbuild makes when it has made messages and services; catkin makes none (run)."""
    known, name = _graph(request)
    if name not in known.by_name:
        print()
        _must_be(known, name)
    found = []
    for each in known.needs(name):
        for kind in ("msg", "srv"):
            file = os.path.join(known.find(each).folder, f"{kind}_gen", "generated")
            if os.path.exists(file):
                found.append(file)
    print(" ".join(found))


def _rosdep(request: Request) -> None:
    known, name = _graph(request)
    _must_be(known, name)
    names = [name] if request.verb == "rosdep0" else [*known.needs(name), name]
    catkin = known.manifest(name).catkin
    keys: set[str] = set()
    for each in names:
        manifest = known.manifest(each)
        keys.update(manifest.system)
        if catkin:  # rosbuild knows of rosdep's names only where a manifest.xml says so
            keys.update(key for _, key in manifest.depends)
    _print(request, sorted(keys) if "json" in request.options else [f"name: {key}" for key in sorted(keys)])


def _vcs(request: Request) -> None:
    known, name = _graph(request)
    _must_be(known, name)
    for each in [name] if request.verb == "vcs0" else [name, *known.needs_first(name)]:
        for kind, url in known.manifest(each).version_control:
            print(f"type: {kind}\turl: {url}")


def _export(request: Request) -> None:
    language, attribute = request.option("lang", "attrib")
    known, name = _graph(request)
    if name not in known.by_name:
        print()
        _must_be(known, name)
    print(" ".join(v for m in _chosen(request, known, name) for v in m.exported(language, attribute)))


def _chosen(request: Request, known: Packages, name: str) -> list[Manifest]:
    names = [*known.needs_first(name)]
    if "deps-only" not in request.options:
        names.insert(0, name)
    return [known.manifest(each) for each in names]


def _plugins(request: Request) -> None:
    (attribute,) = request.option("attrib")
    known, name = _graph(request)
    top = request.options.get("top", "")
    if top:
        _must_be(known, top)
    _must_be(known, name)
    allowed = {top, *known.needs(top)} if top else known.by_name.keys()
    for each in [name, *known.needed_by(name)]:
        if each in allowed:
            values = known.manifest(each).exported(name, attribute)
            if values:
                print(f"{each} {values[0]}")


def _langs(request: Request) -> None:
    """Print the client libraries: packages that need roslang, but for those in ROS_LANG_DISABLE."""
    known = packages("rospack")
    disabled = os.environ.get("ROS_LANG_DISABLE", "").split(os.pathsep)
    print(" ".join(each for each in known.needed_by("roslang") if each not in disabled))


def _flags(request: Request) -> None:
    """Print compiler and linker flags: of catkin packages from pkg-config, of rosbuild's from their exports."""
    known, name = _graph(request)
    _must_be(known, name)
    include = request.verb.startswith("cflags")
    kind = request.verb.rsplit("-", 1)[1]  # I, L, l or other
    words: list[str] = []
    done = False
    for manifest in _chosen(request, known, name):
        if not manifest.catkin:
            for value in manifest.exported("cpp", "cflags" if include else "lflags"):
                words += _of_kind(shlex.split(value), kind)
        elif not done:
            done = manifest.name == name  # its answer has everything that it needs in it
            words += _of_kind(_pkg_config(request.verb, manifest.name), kind)
    unique = dict.fromkeys(words) if kind != "l" else dict.fromkeys(reversed(words))
    result = [*unique] if kind != "l" else [*reversed(unique)]
    print(" ".join(result))


def _of_kind(words: list[str], kind: str) -> list[str]:
    if kind == "other":
        return [word for word in words if word[:2] not in ("-I", "-L", "-l")]
    return [word[2:] for word in words if word.startswith(f"-{kind}")]


def _pkg_config(verb: str, name: str) -> list[str]:
    environ = dict(os.environ)
    paths = [os.path.join(p, "lib", "pkgconfig") for p in environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if p]
    environ["PKG_CONFIG_PATH"] = os.pathsep.join([*paths, *filter(None, [environ.get("PKG_CONFIG_PATH")])])
    command = ["pkg-config", f"--{verb}", name]
    try:
        done = subprocess.run(command, env=environ, capture_output=True, text=True, check=False)
    except OSError as error:
        raise PkgError(f"cannot run pkg-config: {error.strerror}") from error
    if done.returncode:
        raise PkgError(f"'{' '.join(command)}' failed: {done.stderr.strip()}")
    return shlex.split(done.stdout)


def _profile(request: Request) -> None:
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


def _contents(request: Request) -> None:
    """Print the packages of a stack: those in a rosbuild stack's folder; a catkin package is its own stack."""
    from pyros1.finding.crawl import all_packages  # noqa: PLC0415

    name = request.package()
    found = all_packages(os.environ)
    stack = next((each for each in found if each.name == name and each.manifest != "manifest.xml"), None)
    if stack is None:
        raise PkgError(f"stack {name} not found", 0)
    if stack.catkin:
        _print(request, [] if stack.meta else [name])
        return
    inside = stack.folder + os.sep
    _print(request, sorted(p.name for p in found if p.manifest == "manifest.xml" and p.folder.startswith(inside)))


def _contains(request: Request) -> None:
    from pyros1.finding.crawl import all_packages  # noqa: PLC0415

    name = request.package("no package given")
    found = all_packages(os.environ)
    package = next((each for each in found if each.name == name and each.manifest != "stack.xml"), None)
    stack = package if package is not None and package.catkin else None
    if package is not None and stack is None:
        above = [s for s in found if s.manifest == "stack.xml" and package.folder.startswith(s.folder + os.sep)]
        stack = max(above, key=lambda each: len(each.folder), default=None)
    if stack is None:
        raise PkgError(f"stack containing package {name} not found")
    print(stack.folder if request.verb == "contains-path" else stack.name)


STACK_VERBS: dict[str, Callable[[Request], None]] = {
    "contents": _contents,
    "contains": _contains,
    "contains-path": _contains,
    "depends": _all_needs,
    "depends1": _direct_needs,
    "depends-on": _needed_by,
    "depends-on1": _needed_by,
    "depends-why": _why,
    "depends-indent": _tree,
    "depends-manifests": _manifests,
    "profile": _profile,
}
"""Verb of rosstack -> function."""

VERBS: dict[str, Callable[[Request], None]] = {
    **{verb: act for verb, act in STACK_VERBS.items() if not verb.startswith("cont")},
    "depends-msgsrv": _generated,
    "rosdep": _rosdep,
    "rosdep0": _rosdep,
    "vcs": _vcs,
    "vcs0": _vcs,
    "export": _export,
    "plugins": _plugins,
    "langs": _langs,
    "cflags-only-I": _flags,
    "cflags-only-other": _flags,
    "libs-only-L": _flags,
    "libs-only-l": _flags,
    "libs-only-other": _flags,
}
"""Verb of rospack -> function."""
