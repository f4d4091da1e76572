"""Finds the commands and their verbs by name.

The names and descriptions of all commands are in a table, `index.INDEX`, so that only the command to run is imported.
``python -m pyros1.cli.make_index`` generates the table from the commands' records. A test checks that the table is
current. If a module in the folder of commands is missing from the table, the module is imported to read its record.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from pyros1.cli.index import INDEX
from pyros1.cli.records import Command, Verb

COMMANDS_PACKAGE = "pyros1.cli.commands"
SHELL_FUNCTIONS = ("roscd", "rospd", "rosd")
"""Names of shell functions that change the shell's current folder. A program cannot do this."""
_COMMANDS_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "commands")


class VerbEntry:
    """The information about a verb that is available without importing it. See `records.Verb`."""

    __slots__ = ("about", "aliases", "completion_kinds", "module", "stock", "stock_about", "usage")

    def __init__(
        self,
        module: str,
        about: str,
        stock_about: str,
        stock: str | None,
        usage: str,
        completion_kinds: tuple[str, ...],
        aliases: tuple[str, ...],
    ) -> None:
        self.module = module
        self.about = about
        self.stock_about = stock_about
        self.stock = stock
        self.usage = usage
        self.completion_kinds = completion_kinds
        self.aliases = aliases

    @property
    def in_stock_tool(self) -> bool:
        """Whether the command's stock tool has this verb."""
        return self.stock is None

    @property
    def program(self) -> str:
        """The stock program that does the same without any arguments; empty if there is none."""
        return "" if self.stock is None or " " in self.stock else self.stock


class CommandEntry:
    """The information about a command that is available without importing it. See `records.Command`.

    If the command has no verbs, `verbs` is empty and `completion_kinds` contains the kinds of its arguments.
    """

    __slots__ = ("about", "aliases", "completion_kinds", "group", "module", "other_programs", "stock", "verbs")

    def __init__(
        self,
        module: str,
        about: str,
        group: str,
        stock: str,
        other_programs: dict[str, tuple[str, ...]],
        aliases: tuple[str, ...],
        completion_kinds: tuple[str, ...],
        verbs: dict[str, tuple[Any, ...]],
    ) -> None:
        self.module = module
        self.about = about
        self.group = group
        self.stock = stock
        self.other_programs = other_programs
        self.aliases = aliases
        self.completion_kinds = completion_kinds
        self.verbs = {verb: VerbEntry(*fields) for verb, fields in verbs.items()}


def commands() -> dict[str, CommandEntry]:
    """Return all commands by name."""
    entries = {name: CommandEntry(*INDEX[name]) for name in INDEX}
    indexed_modules = {entry.module for entry in entries.values()}
    for module in modules():
        if module not in indexed_modules:
            name, fields = describe_command(module)
            entries[name] = CommandEntry(*fields)
    return entries


def find_command(name: str) -> CommandEntry | None:
    """Return the entry of a command; None if the name is unknown."""
    return CommandEntry(*INDEX[name]) if name in INDEX else commands().get(name)


def stock_names() -> dict[str, tuple[str, ...]]:
    """Map the name of each stock program to the arguments of ``pyros1`` that do the same."""
    args_by_program: dict[str, tuple[str, ...]] = {}
    for name, entry in commands().items():
        if entry.stock:
            args_by_program[entry.stock] = (name,)
        args_by_program.update({stock: (name, *args) for stock, args in entry.other_programs.items()})
        programs = {verb_entry.program: (name, verb) for verb, verb_entry in verbs(name).items()}
        args_by_program.update({stock: args for stock, args in programs.items() if stock not in ("", *SHELL_FUNCTIONS)})
    return dict(sorted(args_by_program.items()))


def completion_kinds(command: str, verb: str, position: int) -> str:
    """Return the kinds of candidates for an argument, separated by ``|``; empty if unknown.

    Args:
        command: the command.
        verb: the verb; empty for a command without verbs.
        position: the argument's position, counted from 0.
    """
    entry = find_command(command)
    kinds = verbs(command)[verb].completion_kinds if verb else entry.completion_kinds if entry else ()
    if position < len(kinds):
        return kinds[position].rstrip("+")
    return kinds[-1].rstrip("+") if kinds and kinds[-1].endswith("+") else ""


def command_name(word: str) -> str | None:
    """Return the name of the command that a word stands for, such as ``topic`` for ``rostopic``; None if unknown.

    Args:
        word: the name of a command, an alias, the name of a stock tool, or a command's name after ``ros``.
    """
    short = word.removeprefix("ros")
    if word in INDEX or (short in INDEX and INDEX[short][3] == word):  # the common case, which is fast
        return word if word in INDEX else short
    for name, entry in commands().items():  # these names have priority: rosconsole is `log`, not `console`
        if word == entry.stock or word in entry.aliases:
            return name
    for name in commands():
        if word in (name, f"ros{name}"):
            return name
    return None


def verbs(command: str) -> dict[str, VerbEntry]:
    """Return the verbs of a command by name, in the order of the table; verbs that the table lacks are last."""
    entry = find_command(command)
    if entry is None:
        return {}
    entries = dict(entry.verbs)
    indexed_modules = {verb.module for verb in entries.values()}
    for module in modules(entry.module):
        if module not in indexed_modules:
            entries.update({verb: VerbEntry(*fields) for verb, fields in describe_verbs(module).items()})
    return entries


def find_verb(command: str, word: str) -> str | None:
    """Return the name of the verb with this name or alias; None if the command has none."""
    entries = verbs(command)
    if word in entries:
        return word
    return next((verb for verb, entry in entries.items() if word in entry.aliases), None)


def load_command(name: str) -> Command:
    """Return the record of an existing command."""
    entry = find_command(name)
    assert entry is not None, name
    return _load_record(entry.module)


def load_verb(command: str, verb: str) -> Verb:
    """Return the record of an existing verb."""
    return next(record for record in _load_verb_records(verbs(command)[verb].module) if record.name == verb)


def describe_command(module: str) -> tuple[str, tuple[Any, ...]]:
    """Import a command's module. Return the command's name and the fields of its entry, without the verbs."""
    record = _load_record(module)
    other_programs = {name: tuple(args) for name, args in record.other_programs.items()}
    kinds = _argument_kinds(record.verb) if record.verb else ()
    return record.name, (module, record.about, record.group, record.stock, other_programs, record.aliases, kinds, {})


def describe_verbs(module: str) -> dict[str, tuple[Any, ...]]:
    """Import a module of verbs. Return a dictionary: verb name -> fields of the verb's entry."""
    return {
        verb.name: (module, verb.about, verb.stock_about, verb.stock, verb.usage, _argument_kinds(verb), verb.aliases)
        for verb in _load_verb_records(module)
    }


def modules(command: str = "") -> list[str]:
    """Return the module names of all commands, or of one command's verbs, relative to `COMMANDS_PACKAGE`."""
    try:
        names = os.listdir(os.path.join(_COMMANDS_FOLDER, command))
    except OSError:  # not a folder: the command is a module, or this code is in an archive
        return []
    module_names = [name.removesuffix(".py") for name in names if name.endswith(".py")]
    if not command:
        module_names += [name for name in names if os.path.exists(os.path.join(_COMMANDS_FOLDER, name, "__init__.py"))]
    prefix = f"{command}." * bool(command)
    return sorted(prefix + name for name in module_names if not name.startswith("_"))


def _argument_kinds(verb: Verb) -> tuple[str, ...]:
    """Return the kinds of candidates for each argument, with a ``+`` if it may be repeated."""
    return tuple(argument.completion_kinds + "+" * argument.repeatable for argument in verb.arguments)


def _load_record(module: str) -> Command:
    record: Command = import_module(f"{COMMANDS_PACKAGE}.{module}").COMMAND
    return record


def _load_verb_records(module: str) -> Iterable[Verb]:
    imported_module = import_module(f"{COMMANDS_PACKAGE}.{module}")
    records: Iterable[Verb] = imported_module.VERBS if hasattr(imported_module, "VERBS") else [imported_module.VERB]
    return records
