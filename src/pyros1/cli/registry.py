"""Finds commands and their verbs.

Names and one-line texts of all commands come from a table (`index`), so that nothing is imported but what runs. The
table is made from the records by ``python -m pyros1.cli.make_index``, and a test checks that it is current. What is in
the folders but not in the table is found, too, and imported to ask it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib import import_module
from typing import NamedTuple

from pyros1.cli.index import INDEX
from pyros1.cli.records import Command, Verb

PACKAGE = "pyros1.cli.commands"
SHELL_FUNCTIONS = ("roscd", "rospd", "rosd")
"""Names of what only a function of the shell can do: changing its folder."""
_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "commands")


class VerbEntry(NamedTuple):
    """What is known of a verb without importing it; see `records.Verb`."""

    module: str
    about: str
    stock_about: str
    own: bool
    usage: str
    completes: tuple[str, ...]
    aliases: tuple[str, ...]


class CommandEntry(NamedTuple):
    """What is known of a command without importing it; see `records.Command`.

    `verbs` is empty if it has none; `completes` then has the kinds of its arguments.
    """

    module: str
    about: str
    group: str
    stock: str
    also: dict[str, tuple[str, ...]]
    aliases: tuple[str, ...]
    completes: tuple[str, ...]
    verbs: dict[str, VerbEntry]


def commands() -> dict[str, CommandEntry]:
    """Return all commands by name."""
    found = {name: _from_index(name) for name in INDEX}
    known = {entry.module for entry in found.values()}
    for module in modules():
        if module not in known:
            name, entry = describe(module)
            found[name] = entry
    return found


def command(name: str) -> CommandEntry | None:
    """Return a command; None if there is none of that name."""
    return _from_index(name) if name in INDEX else commands().get(name)


def _from_index(name: str) -> CommandEntry:
    entry = CommandEntry(*INDEX[name])
    return entry._replace(verbs={verb: VerbEntry(*told) for verb, told in entry.verbs.items()})


def stock_names() -> dict[str, tuple[str, ...]]:
    """Return the names under which users of ROS 1 know commands, each with the words behind ``pyros1`` for it."""
    names: dict[str, tuple[str, ...]] = {}
    for name, entry in commands().items():
        if entry.stock:
            names[entry.stock] = (name,)
        names.update({stock: (name, *words) for stock, words in entry.also.items()})
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
    if word in INDEX:
        return word
    known = commands()
    for name, entry in known.items():
        if word in (name, entry.stock, *entry.aliases):
            return name
    return word[3:] if word.startswith("ros") and word[3:] in known else None


def verbs(name: str) -> dict[str, VerbEntry]:
    """Return the verbs of a command by name, empty if it has none."""
    entry = command(name)
    if entry is None:
        return {}
    found = dict(entry.verbs)
    known = {verb.module for verb in found.values()}
    for module in modules(entry.module):
        if module not in known:
            found.update(describe_verbs(module))
    return dict(sorted(found.items()))


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


def describe(module: str) -> tuple[str, CommandEntry]:
    """Import a command and return its name and entry, without verbs."""
    record = _load(module)
    also = {name: tuple(words) for name, words in record.also.items()}
    kinds = _kinds(record.verb) if record.verb else ()
    return record.name, CommandEntry(module, record.about, record.group, record.stock, also, record.aliases, kinds, {})


def describe_verbs(module: str) -> dict[str, VerbEntry]:
    """Import a file of verbs and return their entries by name."""
    return {
        verb.name: VerbEntry(module, verb.about, verb.stock_about, verb.own, verb.usage, _kinds(verb), verb.aliases)
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
