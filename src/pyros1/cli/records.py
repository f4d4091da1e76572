"""What a command or verb is: one record each, from which usage, help, completion, the tables and the dispatch come.

A command is a module or folder in `pyros1.cli.commands` with a `Command` record named ``COMMAND``, which is in
``__init__.py`` if it is a folder. One that has verbs, such as ``topic``, is a folder with a file for each verb, which
has the verb's record, ``VERB``; nearly the same verbs may share a file, which then has a list of records, ``VERBS``.
Files and folders whose names begin with ``_`` are shared by the verbs of a command.

This module imports nothing that takes time: records are made whenever a command starts.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.cli.invocation import Invocation

Run = Callable[["Invocation", Any, list[str]], "int | None"]
"""Runs a verb: takes the invocation, the options' values, the arguments; returns the exit code, None for 0."""
Parse = Callable[["Invocation", "Verb"], tuple[Any, list[str]]]
"""Takes the invocation and the verb; returns the options' values and the arguments."""


class Option:
    """An option of a verb.

    Args:
        names: ``-w``, ``--window``.
        help: what it does.
        own: stock's tool does not have it: help under that tool's name leaves it out.
        hidden: help always leaves it out.
        settings: as `optparse.OptionParser.add_option` takes them: dest, action, type, default, metavar ...
    """

    __slots__ = ("help", "hidden", "names", "own", "settings")

    def __init__(self, *names: str, help: str = "", own: bool = False, hidden: bool = False, **settings: Any) -> None:
        self.names = names
        self.help = help
        self.own = own
        self.hidden = hidden
        self.settings = settings

    @property
    def dest(self) -> str:
        """The name of the option's value."""
        long = [name for name in self.names if name.startswith("--")]
        name: str = self.settings.get("dest") or (long or self.names)[0].lstrip("-").replace("-", "_")
        return name


class Flag(Option):
    """An option without a value: False unless it is given."""

    __slots__ = ()

    def __init__(self, *names: str, help: str = "", own: bool = False, hidden: bool = False, **settings: Any) -> None:
        settings = {"action": "store_true", "default": False, **settings}
        super().__init__(*names, help=help, own=own, hidden=hidden, **settings)


JSON = Flag("--json", help="print JSON", own=True)


class Argument:
    """An argument of a verb.

    Args:
        name: as usage shows it, for example ``topic``.
        completes: what a shell offers for it: kinds of `pyros1.cli.complete_values`, parted by ``|``.
        many: it may be repeated.
        optional: it may be left out.
        help: what it is, for help that lists arguments.
    """

    __slots__ = ("completes", "help", "many", "name", "optional")

    def __init__(
        self, name: str, completes: str = "", *, many: bool = False, optional: bool = False, help: str = ""
    ) -> None:
        self.name = name
        self.completes = completes
        self.many = many
        self.optional = optional
        self.help = help

    def __str__(self) -> str:
        text = f"{self.name}..." if self.many else self.name
        return f"[{text}]" if self.optional else text


class Verb:
    """One verb of a command, or what a command without verbs does.

    Args:
        name: as it is typed; empty if the command has no verbs.
        about: one line, for the list of verbs.
        parts: its options and its arguments, in order.
        run: does the work.
        usage: what usage shows behind the name; None: made of the parts.
        description: lines of help between usage and options.
        examples: pairs of what is typed behind the name, or a whole line if it begins with ``pyros1``, and what that
            does.
        aliases: other names of it.
        stock: what has the same task in stock ROS 1: a program, such as ``rosls``, with the words behind it, if any;
            empty if nothing has. None: the verb of that name of the command's stock tool. Under that tool's name, the
            list of verbs has only these.
        stock_about: the line in that list under the stock tool's name, where it must be another; empty: there is none.
        stock_examples: help under the stock tool's name has the examples, too.
        parse: makes options and arguments of the words, see `pyros1.cli.parsing`; None: `parse_words`.
    """

    __slots__ = (
        "about", "aliases", "arguments", "description", "examples", "name", "options", "parse", "run", "stock",
        "stock_about", "stock_examples", "usage",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        about: str,
        *parts: Option | Argument,
        run: Run,
        usage: str | None = None,
        description: str = "",
        examples: Sequence[tuple[str, str]] = (),
        aliases: Sequence[str] = (),
        stock: str | None = None,
        stock_about: str | None = None,
        stock_examples: bool = False,
        parse: Parse | None = None,
    ) -> None:
        self.name = name
        self.about = about
        self.options = [part for part in parts if isinstance(part, Option)]
        self.arguments = [part for part in parts if isinstance(part, Argument)]
        self.run = run
        self.usage = usage if usage is not None else " ".join(["[options]"] * bool(self.options) + self._words())
        self.description = description
        self.examples = examples
        self.aliases = tuple(aliases)
        self.stock = stock
        self.stock_about = about if stock_about is None else stock_about
        self.stock_examples = stock_examples
        self.parse = parse

    def examples_text(self, program: str, *, as_stock: bool) -> str:
        """Return the end of help: a block of examples.

        Args:
            program: how the command was called.
            as_stock: it was called by the stock tool's name.
        """
        if not self.examples or (as_stock and not self.stock_examples):
            return ""
        return examples_block(f"{program} {self.name}".rstrip(), self.examples)

    def _words(self) -> list[str]:
        return [str(argument) for argument in self.arguments]


def examples_block(called: str, examples: Sequence[tuple[str, str]]) -> str:
    """Return examples as they end help; see `Verb` for these.

    Args:
        called: what is typed before each, if it is no whole line.
        examples: at least one.
    """
    rows = [(line if line.startswith("pyros1 ") else f"{called} {line}".rstrip(), about) for line, about in examples]
    width = max(len(line) for line, _ in rows)
    return "\nExamples:\n" + "".join(f"  {line:{width}}  {about}".rstrip() + "\n" for line, about in rows)


GROUPS = {
    "run": "Start programs",
    "look": "See and change what runs",
    "files": "Recordings and files",
    "develop": "Messages and packages",
    "machine": "This machine",
}
"""The groups of commands, with their headings in ``pyros1 help``."""


class Command:
    """A command.

    Args:
        name: as it is typed.
        about: one line, for ``pyros1 help``.
        group: under which of `GROUPS` that lists it.
        verb: what it does, of a command without verbs.
        stock: the stock tool's name; empty if there is none.
        also: further programs of stock ROS 1, each with the words behind this command that do the same; those that one
            verb stands for are in its record.
        aliases: other names of the command.
        heading: the first lines of the list of its verbs, with ``{program}`` for how it was called.
        order: verbs that come first in that list, in this order; the others follow by name.
        row: a line of that list, with ``{program}``, ``{name}``, ``{about}`` and ``{usage}``.
        footing: the last lines.
        usage_code: exit code without a known verb.
        error_code: exit code after an error.
        failure: makes the text of an error, where it is not ``ERROR: `` and the error's own; None: that.
        stock_help: words at which the stock tool prints the list of verbs with exit code 0; an empty one: without any.
        names_unknown: the stock tool says which verb it does not know.
        dispatch: finds and runs the verb, where that need not be the first word, and returns the exit code.
    """

    __slots__ = (
        "about", "aliases", "also", "dispatch", "error_code", "failure", "footing", "group", "heading", "name",
        "names_unknown", "order", "row", "stock", "stock_help", "usage_code", "verb",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        about: str,
        verb: Verb | None = None,
        *,
        group: str,
        stock: str = "",
        also: Mapping[str, Sequence[str]] = {},
        aliases: Sequence[str] = (),
        heading: str = "usage: {program} <command> [arguments]\n\nCommands:",
        order: Sequence[str] = (),
        row: str = "  {name:15} {about}",
        footing: str = "\nType {program} <command> -h for more.",
        usage_code: int = 64,
        error_code: int = 1,
        failure: Callable[[Exception], str | None] | None = None,
        stock_help: Collection[str] = (),
        names_unknown: bool = False,
        dispatch: Callable[[Invocation], int | None] | None = None,
    ) -> None:
        self.name = name
        self.about = about
        self.verb = verb
        self.group = group
        self.stock = stock
        self.also = also
        self.aliases = tuple(aliases)
        self.heading = heading
        self.order = order
        self.row = row
        self.footing = footing
        self.usage_code = usage_code
        self.error_code = error_code
        self.failure = failure
        self.stock_help = stock_help
        self.names_unknown = names_unknown
        self.dispatch = dispatch

    def sorted(self, verbs: Iterable[str]) -> list[str]:
        """Return names of verbs in the order of their list."""
        first = {name: number for number, name in enumerate(self.order)}
        return sorted(verbs, key=lambda name: (first.get(name, len(first)), name))

    def help_words(self, *, as_stock: bool) -> Collection[str]:
        """Return the words that ask for the list of verbs."""
        return self.stock_help if as_stock else {"-h", "--help", "help", *self.stock_help}
