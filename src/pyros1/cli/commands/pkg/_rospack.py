"""How ``pkg`` parses and runs a command line, like rospack (L182)."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from pyros1.cli import registry
from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
from pyros1.cli.records import Argument, Flag, Option, Run, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.finding.crawl import FoundPackage, all_packages
from pyros1.ground.errors import Error, PackageNotFoundError

if TYPE_CHECKING:
    from pyros1.finding.dependencies import Packages

_QUIET = Flag("-q", help="Quiets error reports.")
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
        verb: the verb.
        words: the words after it; the package, if one was given.
        options: ``--name=value`` by name; flags have an empty value.
        quiet: whether to print no errors.
        help: whether to print help.
    """

    def __init__(self) -> None:
        self.verb = ""
        self.words: list[str] = []
        self.options: dict[str, str] = {}
        self.quiet = False
        self.help = False

    def package(self) -> str:
        """Return the named package, or the one that contains the current folder."""
        name = self.words[0] if self.words else _package_here()
        if not name:
            raise PkgError("no package given")
        return name

    def option(self, *names: str) -> list[str]:
        """Return the values of required options. A package is required as well."""
        values = [self.options.get(name, "") for name in names]
        if not all(values) or not (self.words or _package_here()):
            raise PkgError(f"no {' / '.join(['package', *names])} given")
        return values

    def print_names(self, names: Iterable[str]) -> None:
        """Print names, as lines or as JSON."""
        if "json" in self.options:
            print_json([*names])
        else:
            print("".join(f"{name}\n" for name in names), end="")


def pack_verb(
    name: str,
    about: str,
    *parts: Option | Argument,
    run: Run,
    examples: Sequence[tuple[str, str]],
    aliases: Sequence[str] = (),
    stock_about: str | None = None,
) -> Verb:
    """Return the record of a verb. `run_tool` parses its words, and it gets a `Request` as its options."""
    return Verb(
        name,
        about,
        *parts,
        _QUIET,
        run=run,
        examples=examples,
        aliases=aliases,
        stock_about=stock_about,
        parse=leave_words,
    )


def run_tool(invocation: Invocation) -> int:
    """Run rospack, whose options may be at any position. Return the exit code: 0, or 1 after an error."""
    request = Request()
    try:
        _parse(request, invocation.argv)
        _act(request, invocation)
    except Error as error:
        sys.stdout.flush()
        if not request.quiet:
            text = f"no such package {error}" if isinstance(error, PackageNotFoundError) else str(error)
            print(f"[rospack] Error: {text}", file=sys.stderr)
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
            request.help = True
        elif word.startswith("--") and name in _VALUES:
            request.options[name] = value if equals else next(waiting, "")
        elif word.startswith("--") and name in _FLAGS and not equals:
            request.options[name] = ""
        else:
            raise PkgError(f"failed to parse command-line options: unrecognised option '{word}'")
    if words[:1] == ["help"]:
        words = words[:1]
    if len(words) > 2 and not request.help:
        raise PkgError("failed to parse command-line options: too many positional options have been specified")
    if words:
        request.verb = words[0]
        request.words = [word for word in words[1:] if word]


def _act(request: Request, invocation: Invocation) -> None:
    if not request.verb and not request.help:
        raise PkgError(f"no command given.  Try '{invocation.program} help'", 0)
    known = {each: entry for each, entry in registry.verbs("pkg").items() if entry.of_tool}
    name = registry.find_verb("pkg", request.verb)
    if request.help:
        if name in known and not invocation.as_stock:
            _print_help(registry.load_verb("pkg", name), invocation)
            return
        request.words, name = [], "help"  # rospack prints its list, whatever the other words are
    if name is None or name not in known:
        others = known if invocation.as_stock else registry.verbs("pkg")
        hint = did_you_mean(request.verb, [each for each in others if each != "help"])
        raise PkgError(f"command {request.verb} not implemented{hint}")
    verb = registry.load_verb("pkg", name)
    if request.words and not verb.arguments:
        raise PkgError("invalid option(s) given")
    request.verb = verb.name
    verb.run(invocation, request, request.words)


def _print_help(verb: Verb, invocation: Invocation) -> None:
    from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed for help

    print(Parser(verb, invocation).format_help(), end="")


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


def known_packages() -> list[FoundPackage]:
    """Return all packages that rospack knows: those that are not metapackages."""
    return [found for found in all_packages(os.environ) if not found.meta and found.manifest != "stack.xml"]


def packages() -> Packages:
    """Return all packages with their dependencies."""
    from pyros1.finding.dependencies import Packages  # noqa: PLC0415

    return Packages(known_packages())
