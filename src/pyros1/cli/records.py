"""The records of commands and verbs. Usage, help, completion, the tables and the dispatch are made from them.

A command is a module or folder in `pyros1.cli.commands` with a `Command` record named ``COMMAND``; in a folder, it is
in ``__init__.py``. A command with verbs, such as ``topic``, is a folder with a file for each verb, which has the verb's
record, ``VERB``. Similar verbs may share a file, which then has a list of records, ``VERBS``. Files and folders whose
names begin with ``_`` are shared by the verbs of a command.

This module imports nothing slow: records are made at each start of a command.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.cli.invocation import Invocation

Run = Callable[["Invocation", Any, list[str]], "int | None"]
"""Runs a verb: takes the invocation, the options' values and the arguments; returns the exit code, None for 0."""
Parse = Callable[["Invocation", "Verb"], tuple[Any, list[str]]]
"""Takes the invocation and the verb; returns the options' values and the arguments."""


class Option:
    """An option of a verb.

    Args:
        names: ``-w``, ``--window``.
        help: what it does.
        own: stock's tool does not have it, so help under that tool's name does not show it.
        hidden: help never shows it.
        settings: arguments of `optparse.OptionParser.add_option`: dest, action, type, default, metavar ...
    """

    __slots__ = ("help", "hidden", "names", "own", "settings")

    def __init__(self, *names: str, help: str = "", own: bool = False, hidden: bool = False, **settings: Any) -> None:
        self.names = names
        self.help = help
        self.own = own
        self.hidden = hidden
        self.settings = settings

    @property
    def takes_value(self) -> bool:
        """Whether the word after it is its value."""
        return self.settings.get("action", "store") in ("store", "append") or "type" in self.settings

    @property
    def dest(self) -> str:
        """The name of the option's value."""
        long = [name for name in self.names if name.startswith("--")]
        name: str = self.settings.get("dest") or (long or self.names)[0].lstrip("-").replace("-", "_")
        return name


class Flag(Option):
    """An option without a value: True if it is given, else False."""

    __slots__ = ()

    def __init__(self, *names: str, help: str = "", own: bool = False, hidden: bool = False, **settings: Any) -> None:
        settings = {"action": "store_true", "default": False, **settings}
        super().__init__(*names, help=help, own=own, hidden=hidden, **settings)


JSON = Flag("--json", help="print JSON", own=True)


class Argument:
    """An argument of a verb.

    Args:
        name: the name in usage texts, for example ``topic``.
        completes: what shells offer for it: kinds of `pyros1.cli.complete_values`, separated by ``|``.
        many: whether it may be repeated.
        optional: whether it may be left out.
        help: its description, for help that lists arguments.
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
    """One verb of a command, or the action of a command without verbs.

    Args:
        name: the name to type; empty if the command has no verbs.
        about: description in one line, for the list of verbs.
        parts: its options and its arguments, in order.
        run: runs the verb.
        usage: the usage text after the name; None derives it from the parts.
        description: lines of help between usage and options.
        examples: pairs of words to type after the name, or a whole line if it begins with ``pyros1``, and what they
            do.
        aliases: other names of the verb.
        stock: the stock program that does the same, such as ``rosls``, with its first words, if any; empty if stock has
            none. None means the verb of the same name of the command's stock tool. Under that tool's name, the list of
            verbs shows only these.
        stock_about: `about` under the stock tool's name, if it differs; empty for no text.
        stock_examples: whether help under the stock tool's name also shows the examples.
        parse: makes options and arguments from the words, see `pyros1.cli.parsing`; None means `parse_words`.
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
            as_stock: whether it was called under the stock tool's name.
        """
        if not self.examples or (as_stock and not self.stock_examples):
            return ""
        return examples_block(f"{program} {self.name}".rstrip(), self.examples)

    def _words(self) -> list[str]:
        return [str(argument) for argument in self.arguments]


def examples_block(called: str, examples: Sequence[tuple[str, str]]) -> str:
    """Return examples as text for the end of help; see `Verb`.

    Args:
        called: the words to type before each, unless it is a whole line.
        examples: at least one.
    """
    rows = [(line if line.startswith("pyros1 ") else f"{called} {line}".rstrip(), about) for line, about in examples]
    width = max(len(line) for line, _ in rows)
    return "\nExamples:\n" + "".join(f"  {line:{width}}  {about}".rstrip() + "\n" for line, about in rows)


GROUPS = {
    "learn": "Get started",
    "run": "Start programs",
    "look": "Inspect and control running nodes",
    "files": "Recordings and files",
    "develop": "Messages and packages",
    "machine": "This machine",
}
"""The groups of commands, with their headings in ``pyros1 help``."""


class Command:
    """A command.

    Args:
        name: the name to type.
        about: description in one line, for ``pyros1 help``.
        group: the one of `GROUPS` that contains it.
        verb: the action of a command without verbs.
        stock: the stock tool's name; empty if stock has no such tool.
        also: further stock programs, each with the words after this command that do the same. Programs for a single
            verb are in the verb's record.
        aliases: other names of the command.
        heading: the first lines of the list of its verbs, with ``{program}`` for how it was called.
        order: verbs that come first in that list, in this order; the remaining ones follow by name.
        row: a line of that list, with ``{program}``, ``{name}``, ``{about}`` and ``{usage}``.
        footing: the last lines of that list.
        usage_code: exit code without a known verb.
        error_code: exit code after an error.
        failure: makes the text of an error; None means ``ERROR: `` and the error's text.
        stock_help: words after which the stock tool prints the list of verbs with exit code 0; an empty word stands
            for no words.
        names_unknown: whether the stock tool prints the name of an unknown verb.
        dispatch: finds and runs a verb that need not be the first word, and returns the exit code.
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
