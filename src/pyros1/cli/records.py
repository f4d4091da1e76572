"""The records of commands and verbs. Usage, help, completion, dispatch and the tables in documents come from them.

A command is a module or folder in `pyros1.cli.commands` with a `Command` record named ``COMMAND``. The record of a
folder is in its ``__init__.py``. A command with verbs, such as ``topic``, is a folder with a file for each verb. The
file has the verb's record, ``VERB``, or, if similar verbs share the file, a list of their records, ``VERBS``. Files and
folders whose names begin with ``_`` contain code that the verbs of a command share.

This module imports nothing slow, since records are created each time a command starts.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.cli.invocation import Invocation

RunFunction = Callable[["Invocation", Any, list[str]], "int | None"]
"""Runs a verb with the invocation, the parsed options and the arguments. Returns the exit code; None means 0."""
ParseFunction = Callable[["Invocation", "Verb"], tuple[Any, list[str]]]
"""Returns the parsed options and the arguments of an invocation of a verb."""


class Option:
    """An option of a verb.

    Args:
        names: the names, such as ``-w`` and ``--window``.
        help: the description.
        pyros1_only: whether the stock tool lacks the option, so that its help does not show it.
        hidden: whether help never shows the option.
        settings: arguments of `optparse.OptionParser.add_option`: dest, action, type, default, metavar ...
    """

    __slots__ = ("help", "hidden", "names", "pyros1_only", "settings")

    def __init__(
        self, *names: str, help: str = "", pyros1_only: bool = False, hidden: bool = False, **settings: Any
    ) -> None:
        self.names = names
        self.help = help
        self.pyros1_only = pyros1_only
        self.hidden = hidden
        self.settings = settings

    @property
    def takes_value(self) -> bool:
        """Whether the argument after the option is its value."""
        return self.settings.get("action", "store") in ("store", "append") or "type" in self.settings

    @property
    def dest(self) -> str:
        """The name of the attribute with the option's value."""
        long_names = [name for name in self.names if name.startswith("--")]
        name: str = self.settings.get("dest") or (long_names or self.names)[0].lstrip("-").replace("-", "_")
        return name


class Flag(Option):
    """An option without a value: True if it is given, otherwise False."""

    __slots__ = ()

    def __init__(
        self, *names: str, help: str = "", pyros1_only: bool = False, hidden: bool = False, **settings: Any
    ) -> None:
        settings = {"action": "store_true", "default": False, **settings}
        super().__init__(*names, help=help, pyros1_only=pyros1_only, hidden=hidden, **settings)


JSON_FLAG = Flag("--json", help="print JSON", pyros1_only=True)


class Argument:
    """A positional argument of a verb.

    Args:
        name: the name in the usage, such as ``topic``.
        completion_kinds: the kinds of candidates for completion, see `pyros1.cli.complete_values`, separated by ``|``.
        repeatable: whether the argument may be repeated.
        optional: whether the argument may be left out.
        help: the description, for help that lists arguments.
    """

    __slots__ = ("completion_kinds", "help", "name", "optional", "repeatable")

    def __init__(
        self, name: str, completion_kinds: str = "", *, repeatable: bool = False, optional: bool = False, help: str = ""
    ) -> None:
        self.name = name
        self.completion_kinds = completion_kinds
        self.repeatable = repeatable
        self.optional = optional
        self.help = help

    def __str__(self) -> str:
        text = f"{self.name}..." if self.repeatable else self.name
        return f"[{text}]" if self.optional else text


class Verb:
    """A verb of a command, or the action of a command without verbs.

    Args:
        name: the name to type; empty if the command has no verbs.
        about: a one-line description for the list of verbs.
        parts: the options and the arguments in order.
        run: the function that runs the verb.
        usage: the usage after the name; None to generate it from the parts.
        description: the text between usage and options in help.
        examples: pairs of a command and its description. The command is what follows the verb's name, or a whole line
            that begins with ``pyros1``.
        aliases: other names of the verb.
        stock: the equivalent stock program, such as ``rosls``, with its first arguments if there are any; empty if
            stock has none. None if the command's stock tool has a verb of the same name; the list of verbs that is
            printed under the stock tool's name contains only such verbs.
        stock_about: the description in the stock tool's list of verbs if it differs from `about`; empty if that list
            lacks the verb.
        stock_examples: whether the stock tool's help also shows the examples.
        parse: the function that parses the arguments, see `pyros1.cli.parsing`. If None, `parse_args` is used.
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
        run: RunFunction,
        usage: str | None = None,
        description: str = "",
        examples: Sequence[tuple[str, str]] = (),
        aliases: Sequence[str] = (),
        stock: str | None = None,
        stock_about: str | None = None,
        stock_examples: bool = False,
        parse: ParseFunction | None = None,
    ) -> None:
        self.name = name
        self.about = about
        self.options = [part for part in parts if isinstance(part, Option)]
        self.arguments = [part for part in parts if isinstance(part, Argument)]
        self.run = run
        self.usage = (
            usage if usage is not None else " ".join(["[options]"] * bool(self.options) + self._argument_usage())
        )
        self.description = description
        self.examples = examples
        self.aliases = tuple(aliases)
        self.stock = stock
        self.stock_about = about if stock_about is None else stock_about
        self.stock_examples = stock_examples
        self.parse = parse

    def examples_text(self, program: str, *, as_stock: bool) -> str:
        """Return the block of examples at the end of help; empty if no examples are shown.

        Args:
            program: the name by which the command was called.
            as_stock: whether the command was called by the stock tool's name.
        """
        if not self.examples or (as_stock and not self.stock_examples):
            return ""
        return examples_block(f"{program} {self.name}".rstrip(), self.examples)

    def _argument_usage(self) -> list[str]:
        return [str(argument) for argument in self.arguments]


def examples_block(command: str, examples: Sequence[tuple[str, str]]) -> str:
    """Return the examples as text for the end of help. See `Verb`.

    Args:
        command: the words to type before each example that is not a whole line.
        examples: the examples, at least one.
    """
    rows = [(line if line.startswith("pyros1 ") else f"{command} {line}".rstrip(), about) for line, about in examples]
    width = max(len(line) for line, _ in rows)
    return "\nExamples:\n" + "".join(f"  {line:{width}}  {about}".rstrip() + "\n" for line, about in rows)


COMMAND_GROUPS = {
    "learn": "Get started",
    "run": "Start programs",
    "inspect": "Inspect and control running nodes",
    "files": "Recordings and files",
    "develop": "Messages and packages",
    "machine": "This machine",
}
"""The heading in ``pyros1 help`` for each group of commands."""


class Command:
    """A command.

    Args:
        name: the name to type.
        about: a one-line description for ``pyros1 help``.
        group: the command's group, a key of `COMMAND_GROUPS`.
        verb: the action of a command without verbs.
        stock: the stock tool's name; empty if there is no such tool.
        other_programs: other stock programs, with the equivalent arguments of this command. Programs for a single verb
            are in the verb's record.
        aliases: other names of the command.
        heading: the first lines of the list of verbs, with ``{program}`` for the name by which the command was called.
        order: the first verbs in that list; the others follow in alphabetical order.
        row: the format of a line of that list, with ``{program}``, ``{name}``, ``{about}`` and ``{usage}``.
        footer: the last lines of that list.
        usage_exit_code: the exit code if the verb is missing or unknown.
        error_exit_code: the exit code after an error.
        format_error: called with an error; returns the text to print. If this argument or the returned value is None,
            the text is ``ERROR: `` followed by the error's message.
        stock_help: arguments for which the stock tool prints the list of verbs with exit code 0; an empty string
            represents no arguments.
        prints_unknown_verb: whether the stock tool prints the name of an unknown verb.
        dispatch: for a command whose verb need not be the first argument: the function that finds and runs the verb,
            and returns the exit code.
    """

    __slots__ = (
        "about",
        "aliases",
        "dispatch",
        "error_exit_code",
        "footer",
        "format_error",
        "group",
        "heading",
        "name",
        "order",
        "other_programs",
        "prints_unknown_verb",
        "row",
        "stock",
        "stock_help",
        "usage_exit_code",
        "verb",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        about: str,
        verb: Verb | None = None,
        *,
        group: str,
        stock: str = "",
        other_programs: Mapping[str, Sequence[str]] = {},
        aliases: Sequence[str] = (),
        heading: str = "usage: {program} <command> [arguments]\n\nCommands:",
        order: Sequence[str] = (),
        row: str = "  {name:15} {about}",
        footer: str = "\nType {program} <command> -h for more.",
        usage_exit_code: int = 64,
        error_exit_code: int = 1,
        format_error: Callable[[Exception], str | None] | None = None,
        stock_help: Collection[str] = (),
        prints_unknown_verb: bool = False,
        dispatch: Callable[[Invocation], int | None] | None = None,
    ) -> None:
        self.name = name
        self.about = about
        self.verb = verb
        self.group = group
        self.stock = stock
        self.other_programs = other_programs
        self.aliases = tuple(aliases)
        self.heading = heading
        self.order = order
        self.row = row
        self.footer = footer
        self.usage_exit_code = usage_exit_code
        self.error_exit_code = error_exit_code
        self.format_error = format_error
        self.stock_help = stock_help
        self.prints_unknown_verb = prints_unknown_verb
        self.dispatch = dispatch

    def sorted(self, verbs: Iterable[str]) -> list[str]:
        """Return the names of verbs in the order in which the list of verbs shows them."""
        positions = {name: number for number, name in enumerate(self.order)}
        return sorted(verbs, key=lambda name: (positions.get(name, len(positions)), name))

    def help_words(self, *, as_stock: bool) -> Collection[str]:
        """Return the arguments that request the list of verbs."""
        return self.stock_help if as_stock else {"-h", "--help", "help", *self.stock_help}
