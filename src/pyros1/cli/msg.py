"""``pyros1 msg`` and ``pyros1 srv``: rosmsg and rossrv (L86-L89)."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from itertools import islice
from typing import TYPE_CHECKING

from pyros1.cli.common import CommandError, Invocation, fail, run
from pyros1.errors import DefinitionError, UnknownTypeError

if TYPE_CHECKING:
    from optparse import OptionParser

    from pyros1.finding.library import Library
    from pyros1.msgs.spec import MessageSpec, ServiceSpec


MOST_LINES = 100_000
"""Most lines that a type is shown in: each level can hold the next one many times."""


class Kind:
    """Messages or services: what the two commands differ in.

    Attributes:
        extension: of definition files, ``msg`` or ``srv``.
        word: in texts.
    """

    def __init__(self, extension: str, word: str, capital: str) -> None:
        self.extension = extension
        self.word = word
        self.capital = capital

    def names(self, library: Library, package: str) -> list[str]:
        """The full names of a package's types, sorted."""
        short = library.messages(package) if self.extension == "msg" else library.services(package)
        return [f"{package}/{name}" for name in short]

    def spec(self, library: Library, name: str) -> MessageSpec | ServiceSpec:
        """A definition."""
        return library.message(name) if self.extension == "msg" else library.service(name)


MESSAGES = Kind("msg", "message", "Message")
SERVICES = Kind("srv", "service", "Service")


def _kind(invocation: Invocation) -> Kind:
    return SERVICES if invocation.stock == "rossrv" else MESSAGES


def usage(program: str, kind: Kind) -> str:
    """The command list."""
    word, capital = kind.word, kind.capital
    return f"""{program} is a command-line tool for displaying information about ROS {capital} types.

Commands:
\t{program} show\tShow {word} description
\t{program} info\tAlias for {program} show
\t{program} list\tList all {word}s
\t{program} md5\tDisplay {word} md5sum
\t{program} package\tList {word}s in a package
\t{program} packages\tList packages that contain {word}s

Type {program} <command> -h for more detailed usage
"""


@cache
def _library() -> Library:
    from pyros1.finding.library import Library  # noqa: PLC0415

    return Library(os.environ)


# Verbs ----------------------------------------------------------------------------------------------------------------


def show(invocation: Invocation) -> None:
    """``msg show|info TYPE`` (L86)."""
    kind = _kind(invocation)
    parser = invocation.parser(f"{invocation.verb} [options] <{kind.word} type>")
    parser.add_option(
        "-r", "--raw", action="store_true", default=False, help="show raw message text, including comments"
    )
    parser.add_option("-b", "--bag", metavar="BAGFILE", help=f"show {kind.word} from .bag file")
    invocation.add_chunk_limit(parser)
    options, args = parser.parse_args(invocation.args)
    name = _type_argument(parser, args, kind)
    if options.bag:
        for text in _from_bag(options.bag, name, options.raw):
            print(text)
        return
    names, bare = _candidates(kind, name)
    for full_name in names:
        try:
            spec = kind.spec(_library(), full_name)
            text = spec.text if options.raw else describe(spec, _library().message)
        except (DefinitionError, UnknownTypeError) as error:
            said = "Unable to load msg" if kind is MESSAGES else "Unknown srv type"
            fail(f"{said} [{full_name}]: {error}")
        print((f"[{full_name}]:\n" if bare else "") + text)


def list_types(invocation: Invocation) -> None:
    """``msg list``: all types (L88)."""
    options, _ = _parse(invocation, "")
    library, kind = _library(), _kind(invocation)
    _print([name for package in library.packages() for name in kind.names(library, package)], options.json)


def md5(invocation: Invocation) -> None:
    """``msg md5 TYPE`` (L88). A type that is not known is told on stderr, with exit code 0 as stock's."""
    kind = _kind(invocation)
    parser = invocation.parser(f"md5 <{kind.word} type>")
    _, args = parser.parse_args(invocation.args)
    name = _type_argument(parser, args, kind)
    names, bare = find(kind, name)
    if bare and not names:
        print(f"No {kind.word}s matching the name [{name}]", file=sys.stderr)
    for full_name in names:
        try:
            total = _library().digests.md5(kind.spec(_library(), full_name))
        except UnknownTypeError:
            print(f"Cannot locate [{full_name}]{_near(kind, full_name)}", file=sys.stderr)
            continue
        print(f"[{full_name}]: {total}" if bare else total)


def package(invocation: Invocation) -> None:
    """``msg package PACKAGE``: the types of a package (L88, L89)."""
    kind = _kind(invocation)
    options, args = _parse(invocation, " <package>", f"list all {kind.extension}s on a single line")
    name = args[0] if args else _from_stdin()
    library = _library()
    if not library.has_package(name):
        from pyros1.finding.packages import PackageIndex  # noqa: PLC0415

        known = PackageIndex(os.environ).paths()
        if name not in known:
            from pyros1.suggest import did_you_mean  # noqa: PLC0415

            fail(f"Invalid package: {name}{did_you_mean(name, {*known, *library.packages()})}", 64)
    names = kind.names(library, name)
    if options.json:
        _print(names, as_json=True)
    else:
        print((" " if options.single_line else "\n").join(names))


def packages(invocation: Invocation) -> None:
    """``msg packages``: packages that have such types (L88)."""
    options, _ = _parse(invocation, "", "list all packages on a single line")
    library, kind = _library(), _kind(invocation)
    names = [name for name in library.packages() if kind.names(library, name)]
    if options.json:
        _print(names, as_json=True)
    else:
        print((" " if options.single_line else "\n").join(names))


_VERBS = {
    "show": show, "info": show, "list": list_types, "md5": md5, "package": package, "packages": packages,
}  # fmt: skip


def main(argv: list[str]) -> int:
    """Run ``msg <verb> ...``; returns the exit code."""
    return _main("rosmsg", argv, MESSAGES)


def main_srv(argv: list[str]) -> int:
    """Run ``srv <verb> ...``; returns the exit code."""
    return _main("rossrv", argv, SERVICES)


def _main(stock: str, argv: list[str], kind: Kind) -> int:
    return run(stock, argv, _VERBS, lambda program: usage(program, kind), usage_code=64 if argv else 0)


# Arguments ------------------------------------------------------------------------------------------------------------


def _parse(invocation: Invocation, arguments: str, single_line: str | None = None):  # type: ignore[no-untyped-def]
    parser = invocation.parser(invocation.verb + arguments)
    if single_line is not None:
        parser.add_option("-s", dest="single_line", action="store_true", default=False, help=single_line)
    invocation.add_json(parser, "print a JSON list")
    options, args = parser.parse_args(invocation.args)
    if arguments and len(args) > 1:
        parser.error(f"you may only specify one {_kind(invocation).word} type")  # stock's words, though it is a package
    return options, args


def _print(names: list[str], as_json: bool) -> None:
    if as_json:
        import json  # noqa: PLC0415

        print(json.dumps(names))
    elif names:
        print("\n".join(names))


def _from_stdin() -> str:
    """What was not given as an argument is read from standard input, so that it can come through a pipe."""
    if sys.stdin.isatty():
        fail("no name was given: write it behind the command, or send it through a pipe", 64)
    for line in sys.stdin:
        if line.strip():
            return line.strip()
    return fail("no name was given", 64)


def _type_argument(parser: OptionParser, args: list[str], kind: Kind) -> str:
    if len(args) > 1:
        parser.error(f"you may only specify one {kind.word} type")
    name = args[0] if args else _from_stdin()
    if "::" in name:
        parser.error(
            "rosmsg does not understand C++-style namespaces (i.e. '::').\n"
            "Please refer to msg/srv types as 'package_name/Type'."
        )
    name = name.removesuffix("." + kind.extension)
    if "." in name:
        parser.error(f"invalid message type '{name}'.\nPlease refer to msg/srv types as 'package_name/Type'.")
    return name


def find(kind: Kind, name: str) -> tuple[list[str], bool]:
    """The full names that a name may mean, and whether it came without a package."""
    if "/" in name:
        return [name], False
    library = _library()
    return [
        f"{package}/{name}" for package in library.packages() if f"{package}/{name}" in kind.names(library, package)
    ], True


def _candidates(kind: Kind, name: str) -> tuple[list[str], bool]:
    names, bare = find(kind, name)
    if not names:
        raise CommandError(f"Could not find msg '{name}'{_near(kind, name)}", plain=True)
    return names, bare


def _near(kind: Kind, name: str) -> str:
    from pyros1.suggest import did_you_mean  # noqa: PLC0415

    library = _library()
    everything = [full for package in library.packages() for full in kind.names(library, package)]
    return did_you_mean(name, everything if "/" in name else {full.partition("/")[2] for full in everything})


# Texts ----------------------------------------------------------------------------------------------------------------


def describe(spec: MessageSpec | ServiceSpec, resolve: Callable[[str], MessageSpec]) -> str:
    """Return a definition with those of nested types below each field.

    Args:
        resolve: returns the spec of a full type name.

    Raises:
        DefinitionError: a type contains itself, or there are more than MOST_LINES lines.
    """
    from pyros1.msgs.digest import Digests  # noqa: PLC0415
    from pyros1.msgs.spec import MessageSpec  # noqa: PLC0415

    Digests(resolve).dependencies(spec)  # there must be an end to them
    parts = (spec,) if isinstance(spec, MessageSpec) else (spec.request, spec.response)
    texts = ["".join(line + "\n" for line in islice(_lines(part, resolve, ""), MOST_LINES + 1)) for part in parts]
    if any(text.count("\n") > MOST_LINES for text in texts):
        raise DefinitionError(
            f"more than {MOST_LINES} lines with all types written out; --raw shows the text", spec.name
        )
    return "---\n".join(texts)


def _lines(spec: MessageSpec, resolve: Callable[[str], MessageSpec], indent: str) -> Iterator[str]:
    for constant in spec.constants:
        yield f"{indent}{constant.type} {constant.name}={constant.text}"
    for field in spec.fields:
        yield f"{indent}{field.type} {field.name}"
        if not field.is_builtin:
            yield from _lines(resolve(field.base), resolve, indent + "  ")


def _from_bag(path: str, name: str, raw: bool) -> Iterator[str]:
    """The definitions of a type in a bag, each once."""
    if not os.path.isfile(path):
        raise CommandError(f"bag file [{path}] does not exist")
    from pyros1 import bag as bags  # noqa: PLC0415 - only here are bags needed
    from pyros1.msgs.digest import split_full_text  # noqa: PLC0415
    from pyros1.msgs.spec import parse_message  # noqa: PLC0415

    with bags.open(path) as bag:
        texts = {connection.text("message_definition"): connection.type for connection in bag.connections}
    shown = set()
    for text, type_name in texts.items():
        parts = split_full_text(type_name, text)
        if name not in parts or (parts[name] in shown):
            continue
        shown.add(parts[name])
        if raw:
            yield (text if type_name == name else parts[name]).removesuffix("\n")
        else:
            yield describe(parse_message(name, parts[name], path), partial(_part, parts, path))


def _part(texts: Mapping[str, str], path: str, name: str) -> MessageSpec:
    from pyros1.msgs.spec import parse_message  # noqa: PLC0415

    if name not in texts:
        raise CommandError(f"[{path}] holds no definition of {name}")
    return parse_message(name, texts[name], path)
