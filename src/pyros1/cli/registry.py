"""Finds commands and their verbs.

Names and descriptions of all commands come from a table (`index`), so that only the command that runs is imported.
``python -m pyros1.cli.make_index`` makes the table from the records, and a test checks that it is current. Commands in
the folders that are missing from the table are imported and found as well.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from pyros1.cli.index import INDEX
from pyros1.cli.records import Command, Verb

PACKAGE = "pyros1.cli.commands"
SHELL_FUNCTIONS = ("roscd", "rospd", "rosd")
"""Names of shell functions that change the shell's current folder, which no program can do."""
_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "commands")


class VerbEntry:
    """What is known about a verb without importing it; see `records.Verb`."""

    __slots__ = ("about", "aliases", "completes", "module", "stock", "stock_about", "usage")

    def __init__(
        self,
        module: str,
        about: str,
        stock_about: str,
        stock: str | None,
        usage: str,
        completes: tuple[str, ...],
        aliases: tuple[str, ...],
    ) -> None:
        self.module = module
        self.about = about
        self.stock_about = stock_about
        self.stock = stock
        self.usage = usage
        self.completes = completes
        self.aliases = aliases

    @property
    def of_tool(self) -> bool:
        """Whether the command's stock tool has this verb."""
        return self.stock is None

    @property
    def program(self) -> str:
        """The stock program that does the same without further words; empty if stock has none."""
        return "" if self.stock is None or " " in self.stock else self.stock


class CommandEntry:
    """What is known about a command without importing it; see `records.Command`.

    If it has no verbs, `verbs` is empty and `completes` has the kinds of its arguments.
    """

    __slots__ = ("about", "aliases", "also", "completes", "group", "module", "stock", "verbs")

    def __init__(
        self,
        module: str,
        about: str,
        group: str,
        stock: str,
        also: dict[str, tuple[str, ...]],
        aliases: tuple[str, ...],
        completes: tuple[str, ...],
        verbs: dict[str, tuple[Any, ...]],
    ) -> None:
        self.module = module
        self.about = about
        self.group = group
        self.stock = stock
        self.also = also
        self.aliases = aliases
        self.completes = completes
        self.verbs = {verb: VerbEntry(*facts) for verb, facts in verbs.items()}


def commands() -> dict[str, CommandEntry]:
    """Return all commands by name."""
    found = {name: CommandEntry(*INDEX[name]) for name in INDEX}
    known = {entry.module for entry in found.values()}
    for module in modules():
        if module not in known:
            name, facts = describe(module)
            found[name] = CommandEntry(*facts)
    return found


def command(name: str) -> CommandEntry | None:
    """Return a command by its name, None if it is unknown."""
    return CommandEntry(*INDEX[name]) if name in INDEX else commands().get(name)


def stock_names() -> dict[str, tuple[str, ...]]:
    """Return the stock names of commands, each with the words after ``pyros1`` that do the same."""
    names: dict[str, tuple[str, ...]] = {}
    for name, entry in commands().items():
        if entry.stock:
            names[entry.stock] = (name,)
        names.update({stock: (name, *words) for stock, words in entry.also.items()})
        found = {facts.program: (name, verb) for verb, facts in verbs(name).items()}
        names.update({stock: words for stock, words in found.items() if stock not in ("", *SHELL_FUNCTIONS)})
    return dict(sorted(names.items()))


def completes(name: str, verb: str, position: int) -> str:
    """Return the kinds of an argument, separated by ``|``; empty if unknown.

    Args:
        name: the command.
        verb: its verb; empty for a command without verbs.
        position: number of arguments before this one.
    """
    entry = command(name)
    kinds = verbs(name)[verb].completes if verb else entry.completes if entry else ()
    if position < len(kinds):
        return kinds[position].rstrip("+")
    return kinds[-1].rstrip("+") if kinds and kinds[-1].endswith("+") else ""


def command_name(word: str) -> str | None:
    """Return the command that a word means, by name or stock name: ``topic`` or ``rostopic``. None if unknown."""
    short = word.removeprefix("ros")
    if word in INDEX or (short in INDEX and INDEX[short][3] == word):  # the common case, which is fast
        return word if word in INDEX else short
    for name, entry in commands().items():  # rosconsole is not the command `console`
        if word == entry.stock or word in entry.aliases:
            return name
    for name in commands():
        if word in (name, f"ros{name}"):
            return name
    return None


def verbs(name: str) -> dict[str, VerbEntry]:
    """Return the verbs of a command by name, in the order of its list, new ones last. Empty for none."""
    entry = command(name)
    if entry is None:
        return {}
    found = dict(entry.verbs)
    known = {verb.module for verb in found.values()}
    for module in modules(entry.module):
        if module not in known:
            found.update({verb: VerbEntry(*facts) for verb, facts in describe_verbs(module).items()})
    return found


def find_verb(name: str, word: str) -> str | None:
    """Return the name of the verb that a word means, None if it is unknown."""
    known = verbs(name)
    if word in known:
        return word
    return next((verb for verb, entry in known.items() if word in entry.aliases), None)


def load_command(name: str) -> Command:
    """Return the record of an existing command."""
    entry = command(name)
    assert entry is not None, name
    return _load(entry.module)


def load_verb(name: str, verb: str) -> Verb:
    """Return the record of an existing verb."""
    return next(each for each in _records(verbs(name)[verb].module) if each.name == verb)


def describe(module: str) -> tuple[str, tuple[Any, ...]]:
    """Import a command. Return its name and the parts of its entry, without the verbs."""
    record = _load(module)
    also = {name: tuple(words) for name, words in record.also.items()}
    kinds = _kinds(record.verb) if record.verb else ()
    return record.name, (module, record.about, record.group, record.stock, also, record.aliases, kinds, {})


def describe_verbs(module: str) -> dict[str, tuple[Any, ...]]:
    """Import a file of verbs. Return the parts of their entries, by name."""
    return {
        verb.name: (module, verb.about, verb.stock_about, verb.stock, verb.usage, _kinds(verb), verb.aliases)
        for verb in _records(module)
    }


def modules(command: str = "") -> list[str]:
    """Return the modules of all commands, or of one command's verbs, without helpers and the `PACKAGE` prefix."""
    try:
        names = os.listdir(os.path.join(_FOLDER, command))
    except OSError:  # a module, or an archive, whose commands are all in the table
        return []
    found = [name.removesuffix(".py") for name in names if name.endswith(".py")]
    if not command:
        found += [name for name in names if os.path.exists(os.path.join(_FOLDER, name, "__init__.py"))]
    lead = f"{command}." * bool(command)
    return sorted(lead + name for name in found if not name.startswith("_"))


def _kinds(verb: Verb) -> tuple[str, ...]:
    """Return the completion of each argument; the last has a ``+`` if it may be repeated."""
    return tuple(argument.completes + "+" * argument.many for argument in verb.arguments)


def _load(module: str) -> Command:
    record: Command = import_module(f"{PACKAGE}.{module}").COMMAND
    return record


def _records(module: str) -> Iterable[Verb]:
    loaded = import_module(f"{PACKAGE}.{module}")
    found: Iterable[Verb] = loaded.VERBS if hasattr(loaded, "VERBS") else [loaded.VERB]
    return found
