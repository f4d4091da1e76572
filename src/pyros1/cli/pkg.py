"""``pyros1 pkg`` and ``pyros1 stack``: rospack and rosstack (L182, L183), and making packages."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from pyros1.cli.common import did_you_mean, print_json, program_name
from pyros1.errors import Error, PackageNotFoundError
from pyros1.finding.crawl import Found, all_packages, find_quickly
from pyros1.finding.packages import OWN_PACKAGES

if TYPE_CHECKING:
    from pyros1.finding.dependencies import Packages

_ALIASES = {"deps": "depends", "deps1": "depends1", "deps-indent": "depends-indent", "deps-why": "depends-why",
            "deps-manifests": "depends-manifests", "deps-msgsrv": "depends-msgsrv", "deps-on": "depends-on",
            "deps-on1": "depends-on1", "rosdeps": "rosdep", "rosdeps0": "rosdep0"}  # fmt: skip
_FLAGS = ("deps-only", "zombie-only", "json")
_VALUES = ("target", "lang", "attrib", "top", "length")


class PkgError(Error):
    """Ends the command.

    Args:
        text: printed.
        code: exit code.
    """

    def __init__(self, text: str, code: int = 1) -> None:
        self.code = code
        super().__init__(text)


class Request:
    """One command line.

    Attributes:
        stock: ``rospack`` or ``rosstack``.
        verb: the verb.
        words: what is behind it; the package, if one was given.
        options: ``--name=value`` by name; flags have an empty value.
        quiet: print no errors.
    """

    def __init__(self, stock: str) -> None:
        self.stock = stock
        self.verb = ""
        self.words: list[str] = []
        self.options: dict[str, str] = {}
        self.quiet = False

    @property
    def unit(self) -> str:
        """What the command is about: ``package`` or ``stack``."""
        return "package" if self.stock == "rospack" else "stack"

    def package(self, error: str | None = None) -> str:
        """The package: the one named, or the one that the current folder is in.

        Args:
            error: text if there is none.
        """
        name = self.words[0] if self.words else _package_here()
        if not name:
            raise PkgError(error or f"no {self.unit} given")
        return name

    def option(self, *names: str) -> list[str]:
        """The values of options that must be given, and that there is a package."""
        values = [self.options.get(name, "") for name in names]
        if not all(values) or not (self.words or _package_here()):
            raise PkgError(f"no {' / '.join(['package', *names])} given")
        return values


def _package_here() -> str:
    from pathlib import Path  # noqa: PLC0415

    from pyros1.finding.manifest import ManifestError, read_manifest  # noqa: PLC0415

    here = Path.cwd()
    for folder in (here, *here.parents):
        for name in ("package.xml", "manifest.xml"):
            if (folder / name).is_file():
                try:
                    return read_manifest(folder / name).name
                except ManifestError:
                    return folder.name
    return ""


def known_to(stock: str) -> list[Found]:
    """All that a tool knows: rospack all packages but metapackages, rosstack these and stacks, but no manifest.xml."""
    if stock == "rospack":
        return [found for found in all_packages(os.environ) if not found.meta and found.manifest != "stack.xml"]
    return [found for found in all_packages(os.environ) if found.manifest != "manifest.xml"]


def packages(stock: str) -> Packages:
    """What a tool knows, with what each needs."""
    from pyros1.finding.dependencies import Packages  # noqa: PLC0415

    return Packages(known_to(stock))


def _listed(request: Request) -> dict[str, Found]:
    """Each package's first place, sorted."""
    first = {found.name: found for found in reversed(known_to(request.stock))}
    return {name: first[name] for name in sorted(first)}


# Verbs ----------------------------------------------------------------------------------------------------------------


def find(request: Request) -> None:
    """``pkg find NAME``: its folder."""
    name = request.package()
    quick = find_quickly(os.environ, name) if request.stock == "rospack" else None
    if quick is not None and not quick.meta:
        print(quick.folder)
        return
    known = _listed(request)
    if name not in known:
        hint = did_you_mean(name, known)
        raise PkgError(f"{request.unit} '{name}' not found{hint}")
    print(known[name].folder)


def list_all(request: Request) -> None:
    """``pkg list``: names and folders."""
    known = _listed(request)
    if "json" in request.options:
        print_json({name: found.folder for name, found in known.items()})
        return
    print("".join(f"{name} {found.folder}\n" for name, found in known.items()), end="")


def list_names(request: Request) -> None:
    """``pkg list-names``: names."""
    known = _listed(request)
    print("".join(f"{name}\n" for name in known), end="") if "json" not in request.options else print_json([*known])


def list_duplicates(request: Request) -> None:
    """``pkg list-duplicates``: names that several packages have, each with its folders, the one that counts first."""
    folders: dict[str, list[str]] = {}
    for found in known_to(request.stock):
        if not found.folder.startswith(OWN_PACKAGES):  # these stand in where there are no others
            folders.setdefault(found.name, []).append(found.folder)
    for name, places in sorted(folders.items()):
        if len(places) > 1:
            print(name, *(f"- {place}" for place in places), sep="\n")


def main(argv: list[str]) -> int:
    """Run ``pyros1 pkg``; returns the exit code."""
    if argv[:1] == ["create"]:
        from pyros1.cli.pkg_create import main as create  # noqa: PLC0415

        return create(argv[1:])
    if argv[:1] and argv[0] in ("cd", "ls", "edit", "cp", "mv", "cat"):
        from pyros1.cli.pkg_files import main as files  # noqa: PLC0415

        return files(argv)
    return run("rospack", argv)


def run(stock: str, argv: Sequence[str]) -> int:
    """Run rospack or rosstack.

    Args:
        stock: ``rospack`` or ``rosstack``.
        argv: the words behind the command.

    Returns:
        The exit code: 0, or 1 after an error.
    """
    request = Request(stock)
    try:
        _parse(request, argv)
        _act(request)
    except Error as error:
        sys.stdout.flush()
        if not request.quiet:
            text = f"no such package {error}" if isinstance(error, PackageNotFoundError) else str(error)
            print(f"[{stock}] Error: {text}", file=sys.stderr)
        return error.code if isinstance(error, PkgError) else 1
    return 0


def _parse(request: Request, argv: Sequence[str]) -> None:
    words = []
    waiting = iter(argv)
    for word in waiting:
        name, equals, value = word.lstrip("-").partition("=")
        if not word.startswith("-"):
            words.append(word)
        elif word == "-q":
            request.quiet = True
        elif word in ("-h", "--help"):
            words.insert(0, "help")
        elif word.startswith("--") and name in _VALUES:
            request.options[name] = value if equals else next(waiting, "")
        elif word.startswith("--") and name in _FLAGS and not equals:
            request.options[name] = ""
        else:
            raise PkgError(f"failed to parse command-line options: unrecognised option '{word}'")
    if words[:1] == ["help"]:
        words = words[:1]
    if len(words) > 2:
        raise PkgError("failed to parse command-line options: too many positional options have been specified")
    if words:
        request.verb = _ALIASES.get(words[0], words[0])
        request.words = [word for word in words[1:] if word]


def _act(request: Request) -> None:
    if not request.verb:
        program = program_name(request.stock)
        raise PkgError(f"no command given.  Try '{program} help'", 0)
    if request.verb == "help":
        from pyros1.cli.pkg_usage import usage  # noqa: PLC0415

        print(usage(program_name(request.stock), request.stock))
        return
    verb = _QUICK.get(request.verb)
    if verb is None:
        from pyros1.cli import pkg_depends  # noqa: PLC0415 - reading manifests is not needed for names

        verbs = pkg_depends.VERBS if request.stock == "rospack" else pkg_depends.STACK_VERBS
        verb = verbs.get(request.verb)
        if verb is None:
            raise PkgError(f"command {request.verb} not implemented{did_you_mean(request.verb, {**_QUICK, **verbs})}")
    if request.words and request.verb in ("list", "list-names", "list-duplicates", "langs", "profile"):
        raise PkgError("invalid option(s) given")
    verb(request)


_QUICK: dict[str, Callable[[Request], None]] = {
    "find": find,
    "list": list_all,
    "list-names": list_names,
    "list-duplicates": list_duplicates,
}
