"""``bag check`` and ``bag fix`` (L139, L140)."""

from __future__ import annotations

import os
from collections.abc import Iterable

from pyros1.bag.api import Bag
from pyros1.bag.container import BagWriter
from pyros1.bag.edit import Copy
from pyros1.bag.errors import BagError
from pyros1.bag.migration import Class, Migrator, Missing, rule_text
from pyros1.bag.reader import RawMessage
from pyros1.bag.records import RECORD_OVERHEAD, Connection
from pyros1.cli.bag_files import different, new_file
from pyros1.cli.common import Invocation
from pyros1.cli.shared.progress import Progress
from pyros1.errors import MessageError
from pyros1.msgs import load_message
from pyros1.shown import one_line

Migration = tuple[Class, Class | None, list[Missing]]


def check(invocation: Invocation) -> int:
    """``bag check BAG [RULES...]``."""
    parser = invocation.parser("check BAG [-g RULEFILE] [EXTRARULES1 EXTRARULES2 ...]")
    parser.description = (
        "Determine whether a bag is playable in the current system, or if it can be migrated. "
        "Rule files are Python programs, and are executed."
    )
    parser.add_option("-g", "--genrules", dest="rulefile", help="generate a rulefile named RULEFILE")
    parser.add_option(
        "-a", "--append", action="store_true", help="append to the end of an existing rulefile after loading it"
    )
    parser.add_option("-n", "--noplugins", action="store_true", help="do not load rulefiles via plugins")
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("You must specify a bag file to check.")
    if options.append and options.rulefile is None:
        parser.error("Cannot specify -a without also specifying -g.")
    if options.rulefile is not None and os.path.isfile(options.rulefile) != bool(options.append):
        reason = "does not exist, and so -a is invalid" if options.append else "already exists. Include -a to append"
        parser.error(f"The file {options.rulefile} {reason}.")
    migrator = make_migrator([*args[1:], *([options.rulefile] if options.append else [])])
    with Bag(args[0], unindexed=False) as bag:
        migrations = _migrations(bag, migrator)
    if not migrations:
        print("Bag file does not need any migrations.")
        return 0
    write_rules(migrations, options.rulefile)
    return 0


def write_rules(migrations: list[Migration], path: str | None) -> None:
    """Print what has to be done, and append the rules that are missing to a file.

    Args:
        migrations: of each type.
        path: the file; None: say how to get one.
    """
    print("The following migrations need to occur:")
    _print_migrations(migrations)
    missing = {old._md5sum: (old, new) for _, _, steps in migrations for old, new in steps}
    if path is None:
        hint = (
            "To generate rules, please run with -g <rulefile>"
            if missing
            else "All rules defined.  Bag is ready to be migrated"
        )
        print(f"\n{hint}")
        return
    texts = [rule_text(old, new) for old, new in missing.values() if new is not None]
    if not texts:
        print(f"\nNo additional rule files needed to be generated.  {path} not created.")
        return
    with open(path, "a", encoding="utf-8") as file:
        file.write("".join(texts))
    print(f"\nThe necessary rule files have been written to: {path}")


def fix(invocation: Invocation) -> int:
    """``bag fix IN OUT [RULES...]``."""
    parser = invocation.parser("fix INBAG OUTBAG [EXTRARULES1 EXTRARULES2 ...]")
    parser.description = (
        "Repair the messages in a bag file so that it can be played in the current system. "
        "Rule files are Python programs, and are executed."
    )
    parser.add_option("-n", "--noplugins", action="store_true", help="do not load rulefiles via plugins")
    parser.add_option("--force", action="store_true", help="proceed with migrations, even if not all rules defined")
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("You must pass input and output bag files.")
    if len(args) < 2:
        parser.error("You must pass an output bag file.")
    source, target, *rules = args
    if not target.endswith(".bag"):
        parser.error("Output file must be a bag file.")
    different(source, target)
    migrator = make_migrator(rules)
    with Bag(source, unindexed=False) as bag:
        if not len(bag):
            raise BagError(source, f"there are no messages in it; {target} was not written")
        failing = migrate(bag, target, migrator, force=bool(options.force))
        if failing:
            print("Bag could not be migrated.  The following migrations could not be performed:")
            _print_migrations(failing)
            print(
                f"Try running '{invocation.program} check' to create the necessary rule files "
                f"or run '{invocation.program} fix' with the '--force' option."
            )
            return 1
    print("Bag migrated successfully.")
    return 0


def migrate(bag: Bag, target: str, migrator: Migrator, *, force: bool = False) -> list[Migration]:
    """Write a bag with the messages of another, brought to the definitions of this system.

    Args:
        target: the new file.
        force: where rules are missing, messages stay as they are.

    Returns:
        What could not be done for lack of rules; nothing is written then.
    """
    failing = [migration for migration in _migrations(bag, migrator) if migration[2]]
    if failing and not force:
        return failing
    with new_file(target) as part, Progress(target, bag.reader.file.size) as progress:
        _Fix(bag, migrator).write(part, progress)
    return []


class _Fix:
    """Writes a bag with the messages of another, migrated where that is possible."""

    def __init__(self, bag: Bag, migrator: Migrator) -> None:
        self._bag = bag
        self._migrator = migrator
        self._new: dict[int, tuple[Class | None, Connection]] = {}
        for number, connection in bag.reader.connections.items():
            self._new[number] = self._plan(connection)

    def _plan(self, connection: Connection) -> tuple[Class | None, Connection]:
        old = self._bag.message_class(connection)
        new = self._migrator.target(old)
        if new is None or self._migrator.missing(old, new) or _same(old, new):
            return None, connection
        fields = {"type": new._type, "md5sum": new._md5sum, "message_definition": new._full_text}
        header = dict(connection.header) | {name: value.encode() for name, value in fields.items()}
        return new, Connection(connection.id, connection.topic, header)

    def write(self, path: str, progress: Progress) -> None:
        done = 0
        with BagWriter(path, cipher=self._bag.reader.file.cipher) as writer:
            out = Copy(writer)
            for stored in self._bag.reader.messages():
                cls, connection = self._new[stored.connection.id]
                done += len(stored.data) + RECORD_OVERHEAD
                progress(done)
                out.write(RawMessage(connection, stored.time, stored.data if cls is None else self._data(stored, cls)))

    def _data(self, stored: RawMessage, cls: Class) -> bytes:
        try:
            encoded = cls._encode(self._migrator.convert(self._bag.decode(stored), cls))
        except MessageError as error:
            raise BagError(self._bag.path, f"message on {stored.connection.topic}: {error}") from error
        return encoded if isinstance(encoded, bytes) else b"".join(encoded)


def _same(old: Class, new: Class) -> bool:
    return (old._type, old._md5sum) == (new._type, new._md5sum)


def make_migrator(rules: Iterable[str]) -> Migrator:
    """Return a migrator with the rules of these files."""
    migrator = Migrator(load_message)
    for path in rules:
        migrator.read_rules(path)
    return migrator


def _migrations(bag: Bag, migrator: Migrator) -> list[Migration]:
    """The types of a bag that are not as they are today: class, its class of today, and what is missing between."""
    found: dict[tuple[str, str], Migration] = {}
    for connection in bag.connections:
        key = (connection.type, connection.md5sum)
        if key in found:
            continue
        try:
            old = bag.message_class(connection)
        except MessageError as error:
            raise BagError(bag.path, f"connection {connection.id} on {one_line(connection.topic)}: {error}") from error
        migration = migration_of(old, migrator)
        if migration is not None:
            found[key] = migration
    return list(found.values())


def migration_of(old: Class, migrator: Migrator) -> Migration | None:
    """Return what a type needs to become that of today: class, its class of today, what is missing; None: nothing."""
    new = migrator.target(old)
    return None if new is not None and _same(old, new) else (old, new, migrator.missing(old, new))


def _print_migrations(migrations: Iterable[Migration]) -> None:
    for old, new, missing in migrations:
        _print_step(old, new, "")
        if missing:
            print(f"    {len(missing)} rules missing:")
            for step in missing:
                _print_step(*step, "    ")


def _print_step(old: Class, new: Class | None, indent: str) -> None:
    print(f"{indent} * From: {old._type} [{old._md5sum}]")
    print(f"{indent}   To:   {'Unknown' if new is None else f'{new._type} [{new._md5sum}]'}")
