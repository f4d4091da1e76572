"""Finds commands and their verbs.

Names and one-line texts of all commands come from a table (`index`), so that nothing is imported but what runs. The
table is made from the records by ``python -m pyros1.cli.make_index``, and a test checks that it is current. What is in
the folders but not in the table is found, too, and imported to ask it.
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
"""Names of what only a function of the shell can do: changing its folder."""
_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "commands")


class VerbEntry:
    """What is known of a verb without importing it; see `records.Verb`."""

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
        """The command's stock tool has this verb."""
        return self.stock is None

    @property
    def program(self) -> str:
        """The program of stock ROS 1 that does the same without any word behind its name; empty if there is none."""
        return "" if self.stock is None or " " in self.stock else self.stock


class CommandEntry:
    """What is known of a command without importing it; see `records.Command`.

    `verbs` is empty if it has none; `completes` then has the kinds of its arguments.
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
        self.verbs = {verb: VerbEntry(*told) for verb, told in verbs.items()}


def commands() -> dict[str, CommandEntry]:
    """Return all commands by name."""
    found = {name: CommandEntry(*INDEX[name]) for name in INDEX}
    known = {entry.module for entry in found.values()}
    for module in modules():
        if module not in known:
            name, told = describe(module)
            found[name] = CommandEntry(*told)
    return found


def command(name: str) -> CommandEntry | None:
    """Return a command; None if there is none of that name."""
    return CommandEntry(*INDEX[name]) if name in INDEX else commands().get(name)


def stock_names() -> dict[str, tuple[str, ...]]:
    """Return the names under which users of ROS 1 know commands, each with the words behind ``pyros1`` for it."""
    names: dict[str, tuple[str, ...]] = {}
    for name, entry in commands().items():
        if entry.stock:
            names[entry.stock] = (name,)
        names.update({stock: (name, *words) for stock, words in entry.also.items()})
        found = {told.program: (name, verb) for verb, told in verbs(name).items()}
        names.update({stock: words for stock, words in found.items() if stock not in ("", *SHELL_FUNCTIONS)})
    return dict(sorted(names.items()))


def completes(name: str, verb: str, position: int) -> str:
    """Return the kinds of an argument, parted by ``|``; empty if nothing is known.

    Args:
        name: the command.
        verb: its verb, empty if it has none.
        position: number of arguments before this one.
    """
    entry = command(name)
    kinds = verbs(name)[verb].completes if verb else entry.completes if entry else ()
    if position < len(kinds):
        return kinds[position].rstrip("+")
    return kinds[-1].rstrip("+") if kinds and kinds[-1].endswith("+") else ""


def command_name(word: str) -> str | None:
    """Return the command that a word means: ``topic`` or, by its stock name, ``rostopic``. None if there is none."""
    for name in (word, word.removeprefix("ros")):  # nearly always, and soon found
        if name in INDEX:
            return name
    for name, entry in commands().items():
        if word in (name, f"ros{name}", entry.stock, *entry.aliases):
            return name
    return None


def verbs(name: str) -> dict[str, VerbEntry]:
    """Return the verbs of a command by name, in the order of its list; new ones at the end. Empty if it has none."""
    entry = command(name)
    if entry is None:
        return {}
    found = dict(entry.verbs)
    known = {verb.module for verb in found.values()}
    for module in modules(entry.module):
        if module not in known:
            found.update({verb: VerbEntry(*told) for verb, told in describe_verbs(module).items()})
    return found


def find_verb(name: str, word: str) -> str | None:
    """Return the name of the verb that a word means, None if there is none."""
    known = verbs(name)
    if word in known:
        return word
    return next((verb for verb, entry in known.items() if word in entry.aliases), None)


def load_command(name: str) -> Command:
    """Return the record of a command that there is."""
    entry = command(name)
    assert entry is not None, name
    return _load(entry.module)


def load_verb(name: str, verb: str) -> Verb:
    """Return the record of a verb that there is."""
    return next(each for each in _records(verbs(name)[verb].module) if each.name == verb)


def describe(module: str) -> tuple[str, tuple[Any, ...]]:
    """Import a command and return its name and what its entry is made of, the verbs left out."""
    record = _load(module)
    also = {name: tuple(words) for name, words in record.also.items()}
    kinds = _kinds(record.verb) if record.verb else ()
    return record.name, (module, record.about, record.group, record.stock, also, record.aliases, kinds, {})


def describe_verbs(module: str) -> dict[str, tuple[Any, ...]]:
    """Import a file of verbs and return what their entries are made of, by name."""
    return {
        verb.name: (module, verb.about, verb.stock_about, verb.stock, verb.usage, _kinds(verb), verb.aliases)
        for verb in _records(module)
    }


def modules(command: str = "") -> list[str]:
    """Return what is in the folder of commands, or in a command's, but for helpers, without `PACKAGE` before it."""
    try:
        names = os.listdir(os.path.join(_FOLDER, command))
    except OSError:  # a module, or an archive, of which the table knows all
        return []
    found = [name.removesuffix(".py") for name in names if name.endswith(".py")]
    if not command:
        found += [name for name in names if os.path.exists(os.path.join(_FOLDER, name, "__init__.py"))]
    lead = f"{command}." * bool(command)
    return sorted(lead + name for name in found if not name.startswith("_"))


def _kinds(verb: Verb) -> tuple[str, ...]:
    """Return what completes each argument; the last with a ``+`` if it may be repeated."""
    return tuple(argument.completes + "+" * argument.many for argument in verb.arguments)


def _load(module: str) -> Command:
    record: Command = import_module(f"{PACKAGE}.{module}").COMMAND
    return record


def _records(module: str) -> Iterable[Verb]:
    loaded = import_module(f"{PACKAGE}.{module}")
    found: Iterable[Verb] = loaded.VERBS if hasattr(loaded, "VERBS") else [loaded.VERB]
    return found
