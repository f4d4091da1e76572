"""Converts old bags to the message definitions installed on this system (L139, L140)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from pyros1.bag.api import Bag
from pyros1.bag.edit.editing import CopyWriter
from pyros1.bag.edit.migration import MessageClass, Migrator, MissingRule
from pyros1.bag.errors import BagError
from pyros1.bag.format.reader import RawMessage
from pyros1.bag.format.records import RECORD_OVERHEAD, Connection
from pyros1.bag.format.writer import BagWriter
from pyros1.ground.errors import MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import load_message

Migration = tuple[MessageClass, MessageClass | None, list[MissingRule]]
"""An outdated type: its class, its current class or None, and the missing rules."""


def make_migrator(rule_paths: Iterable[str]) -> Migrator:
    """Return a migrator that converts to the installed definitions, with the rules from the given files.

    Raises:
        BagError, OSError: as for `Migrator.read_rules`.
    """
    migrator = Migrator(load_message)
    for path in rule_paths:
        migrator.read_rules(path)
    return migrator


def find_migrations(bag: Bag, migrator: Migrator) -> list[Migration]:
    """Return a `Migration` for each outdated type in a bag; raises BagError if a definition in the bag is unusable."""
    migration_by_type: dict[tuple[str, str], Migration] = {}
    for connection in bag.connections:
        key = (connection.type, connection.md5sum)
        if key in migration_by_type:
            continue
        try:
            old_class = bag.message_class(connection)
        except MessageError as error:
            raise BagError(bag.path, f"connection {connection.id} on {one_line(connection.topic)}: {error}") from error
        new_class = migrator.current_class(old_class)
        if new_class is None or not _is_same_type(old_class, new_class):
            migration_by_type[key] = (old_class, new_class, migrator.missing_rules(old_class, new_class))
    return list(migration_by_type.values())


def migration_lines(migrations: Iterable[Migration]) -> Iterator[str]:
    """Yield lines that describe migrations and their missing rules, for the terminal."""
    for old_class, new_class, missing_steps in migrations:
        yield from _step_lines(old_class, new_class, "")
        if missing_steps:
            yield f"    {len(missing_steps)} rules missing:"
            for step in missing_steps:
                yield from _step_lines(*step, "    ")


def _step_lines(old_class: MessageClass, new_class: MessageClass | None, indent: str) -> Iterator[str]:
    yield f"{indent} * From: {old_class._type} [{old_class._md5sum}]"
    yield f"{indent}   To:   {'Unknown' if new_class is None else f'{new_class._type} [{new_class._md5sum}]'}"


class MigratedBagWriter:
    """Writes a bag's messages into a new bag, converting them to the installed definitions where possible.

    Args:
        bag: the old bag.
        migrator: converts the messages.

    Raises:
        MessageError: a definition in the bag is wrong or missing.
    """

    def __init__(self, bag: Bag, migrator: Migrator) -> None:
        self._bag = bag
        self._migrator = migrator
        self._targets: dict[int, tuple[MessageClass | None, Connection]] = {}
        for conn_id, connection in bag.reader.connections.items():
            self._targets[conn_id] = self._choose_target(connection)

    def _choose_target(self, connection: Connection) -> tuple[MessageClass | None, Connection]:
        """Return the new class of a connection's messages, or None if they stay as they are, and the new connection."""
        old_class = self._bag.message_class(connection)
        new_class = self._migrator.current_class(old_class)
        if (
            new_class is None
            or self._migrator.missing_rules(old_class, new_class)
            or _is_same_type(old_class, new_class)
        ):
            return None, connection
        fields = {"type": new_class._type, "md5sum": new_class._md5sum, "message_definition": new_class._full_text}
        header = dict(connection.header) | {name: value.encode() for name, value in fields.items()}
        return new_class, Connection(connection.id, connection.topic, header)

    def write(self, path: str, progress: Callable[[int], object]) -> None:
        """Write the new bag.

        Args:
            path: path of the new bag.
            progress: called with the number of bytes of the old bag that have been processed so far.

        Raises:
            BagError: a bag cannot be read or written, or a message cannot be converted.
        """
        bytes_done = 0
        with BagWriter(path, cipher=self._bag.reader.file.cipher) as writer:
            copier = CopyWriter(writer)
            for stored in self._bag.reader.messages():
                cls, connection = self._targets[stored.connection.id]
                bytes_done += len(stored.data) + RECORD_OVERHEAD
                progress(bytes_done)
                copier.write(
                    RawMessage(connection, stored.time, stored.data if cls is None else self._convert(stored, cls))
                )

    def _convert(self, stored: RawMessage, cls: MessageClass) -> bytes:
        try:
            encoded = cls._encode(self._migrator.convert(self._bag.decode(stored), cls))
        except MessageError as error:
            raise BagError(self._bag.path, f"message on {stored.connection.topic}: {error}") from error
        return encoded if isinstance(encoded, bytes) else b"".join(encoded)


def _is_same_type(old_class: MessageClass, new_class: MessageClass) -> bool:
    return (old_class._type, old_class._md5sum) == (new_class._type, new_class._md5sum)
