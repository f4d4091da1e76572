"""Parses command lines like rospack, and runs them (L182)."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from pyros1.cli import registry
from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_unparsed
from pyros1.cli.records import Argument, Flag, Option, RunFunction, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.finding.crawl import FoundPackage, all_packages
from pyros1.ground.errors import Error, PackageNotFoundError

if TYPE_CHECKING:
    from pyros1.finding.dependencies import Packages

_QUIET_FLAG = Flag("-q", help="Quiets error reports.")
_FLAG_NAMES = ("deps-only", "zombie-only", "json")
_VALUE_OPTION_NAMES = ("target", "lang", "attrib", "top", "length")


class PkgError(Error):
    """Ends the command with an error message.

    Args:
        message: the message.
        code: the exit code.
    """

    def __init__(self, message: str, code: int = 1) -> None:
        self.code = code
        super().__init__(message)


class Request:
    """A parsed command line.

    Attributes:
        verb: the verb.
        args: the arguments after the verb: the package, if one is given.
        options: the values of options such as ``--name=value`` by name; the values of flags are empty.
        quiet: whether to suppress errors.
        help: whether to print help.
    """

    def __init__(self) -> None:
        self.verb = ""
        self.args: list[str] = []
        self.options: dict[str, str] = {}
        self.quiet = False
        self.help = False

    def package(self) -> str:
        """Return the name of the requested package, or of the package that contains the current folder.

        Raises:
            PkgError: no package was requested, and the current folder is in none.
        """
        name = self.args[0] if self.args else _current_package_name()
        if not name:
            raise PkgError("no package given")
        return name

    def required_options(self, *option_names: str) -> list[str]:
        """Return the values of required options.

        Raises:
            PkgError: an option or the package is missing.
        """
        values = [self.options.get(name, "") for name in option_names]
        if not all(values) or not (self.args or _current_package_name()):
            raise PkgError(f"no {' / '.join(['package', *option_names])} given")
        return values

    def print_names(self, names: Iterable[str]) -> None:
        """Print names, one per line or as a JSON list."""
        if "json" in self.options:
            print_json([*names])
        else:
            print("".join(f"{name}\n" for name in names), end="")


def make_verb(
    name: str,
    about: str,
    *parts: Option | Argument,
    run: RunFunction,
    examples: Sequence[tuple[str, str]],
    aliases: Sequence[str] = (),
    stock_about: str | None = None,
) -> Verb:
    """Return the `Verb` for a command of rospack. `run_tool` parses its arguments and passes a `Request` as options."""
    return Verb(
        name,
        about,
        *parts,
        _QUIET_FLAG,
        run=run,
        examples=examples,
        aliases=aliases,
        stock_about=stock_about,
        parse=leave_unparsed,
    )


def run_tool(invocation: Invocation) -> int:
    """Run rospack, which accepts options at any position. Return the exit code."""
    request = Request()
    try:
        _parse(request, invocation.argv)
        _run_verb(request, invocation)
    except Error as error:
        sys.stdout.flush()
        if not request.quiet:
            message = f"no such package {error}" if isinstance(error, PackageNotFoundError) else str(error)
            print(f"[rospack] Error: {message}", file=sys.stderr)
        return error.code if isinstance(error, PkgError) else 1
    return 0


def _parse(request: Request, argv: Sequence[str]) -> None:
    positional_args = []
    remaining = iter(argv)
    for arg in remaining:
        name, equals, value = arg.lstrip("-").partition("=")
        if not arg.startswith("-"):
            positional_args.append(arg)
        elif arg == "-q":
            request.quiet = True
        elif arg in ("-h", "--help"):
            request.help = True
        elif arg.startswith("--") and name in _VALUE_OPTION_NAMES:
            request.options[name] = value if equals else next(remaining, "")
        elif arg.startswith("--") and name in _FLAG_NAMES and not equals:
            request.options[name] = ""
        else:
            raise PkgError(f"failed to parse command-line options: unrecognised option '{arg}'")
    if positional_args[:1] == ["help"]:
        positional_args = positional_args[:1]
    if len(positional_args) > 2 and not request.help:
        raise PkgError("failed to parse command-line options: too many positional options have been specified")
    if positional_args:
        request.verb = positional_args[0]
        request.args = [arg for arg in positional_args[1:] if arg]


def _run_verb(request: Request, invocation: Invocation) -> None:
    if not request.verb and not request.help:
        raise PkgError(f"no command given.  Try '{invocation.program} help'", 0)
    stock_verbs = {verb_name: entry for verb_name, entry in registry.verbs("pkg").items() if entry.in_stock_tool}
    name = registry.find_verb("pkg", request.verb)
    if request.help:
        if name in stock_verbs and not invocation.as_stock:
            _print_help(registry.load_verb("pkg", name), invocation)
            return
        request.args, name = [], "help"  # rospack prints its list regardless of the other arguments
    if name is None or name not in stock_verbs:
        verbs = stock_verbs if invocation.as_stock else registry.verbs("pkg")
        hint = did_you_mean(request.verb, [verb_name for verb_name in verbs if verb_name != "help"])
        raise PkgError(f"command {request.verb} not implemented{hint}")
    verb = registry.load_verb("pkg", name)
    if request.args and not verb.arguments:
        raise PkgError("invalid option(s) given")
    request.verb = verb.name
    verb.run(invocation, request, request.args)


def _print_help(verb: Verb, invocation: Invocation) -> None:
    from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed for help

    print(Parser(verb, invocation).format_help(), end="")


def _current_package_name() -> str:
    from pathlib import Path  # noqa: PLC0415

    from pyros1.finding.manifest import ManifestError, read_manifest  # noqa: PLC0415

    current_folder = Path.cwd()
    for folder in (current_folder, *current_folder.parents):
        for name in ("package.xml", "manifest.xml"):
            if (folder / name).is_file():
                try:
                    return read_manifest(folder / name).name
                except ManifestError:
                    return folder.name
    return ""


def known_packages() -> list[FoundPackage]:
    """Return the packages that rospack lists: all except metapackages and stacks."""
    return [found for found in all_packages(os.environ) if not found.is_meta and found.manifest != "stack.xml"]


def load_packages() -> Packages:
    """Return all packages with their dependencies."""
    from pyros1.finding.dependencies import Packages  # noqa: PLC0415

    return Packages(known_packages())
