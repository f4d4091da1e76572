"""Reads bags of version 1.2 (http://wiki.ros.org/Bags/Format/1.2).

They have messages without chunks, each with the names of its topic and type.

Newer recorders wrote a file header at the beginning and an index at the end; older ones wrote neither. The index is not
needed, since one pass over the file finds all messages and definitions.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from pyros1.bag.format.contents import Messages
from pyros1.bag.format.records import (
    MAX_CONNECTIONS,
    NS,
    OP_DEFINITION,
    OP_MESSAGE,
    Connection,
    Fields,
    RecordError,
    op_of,
    split_record,
    u32,
)

_Key = tuple[bytes, bytes, bytes, bytes, bytes]

_BEGINS = re.compile(rb"...\0...\0(?:callerid|def|latching|md5|nsec|op|sec|topic|type)=", re.DOTALL)
"""Pattern of the beginning of a message or definition record: two lengths below 16 MiB and the name of a field."""

MAX_BEGIN_LENGTH = 17
"""Maximum number of bytes that the pattern matches."""


class OldConnections:
    """Numbers for the connections of a bag of version 1.2.

    Args:
        connections: the dict in which they are kept, by number.
    """

    def __init__(self, connections: dict[int, Connection]) -> None:
        self._connections = connections
        self._numbers: dict[_Key, int] = {}
        self._definitions: dict[tuple[bytes, bytes], bytes] = {}

    def define(self, fields: Fields) -> None:
        """Add a definition record."""
        definition = fields.get("def", b"")
        if len(self._definitions) >= MAX_CONNECTIONS:
            raise RecordError(f"the bag has more than {MAX_CONNECTIONS} definitions")
        kind = fields.get("type", b"")
        self._definitions[kind, fields.get("md5", b"")] = definition
        self._definitions.setdefault((kind, b""), definition)

    def number(self, fields: Fields) -> int:
        """Return the number of a message's connection."""
        names = ("topic", "type", "md5", "callerid", "latching")
        topic, kind, md5, caller, latching = (fields.get(name, b"") for name in names)
        key = (topic, kind, md5, caller, latching)
        found = self._numbers.get(key)
        if found is None:
            if len(self._numbers) >= MAX_CONNECTIONS:
                raise RecordError(f"the bag has more than {MAX_CONNECTIONS} connections")
            found = self._numbers[key] = len(self._numbers)
            known = self._definitions
            definition = known.get((kind, md5)) or known.get((kind, b""), b"")
            header = {"topic": topic, "type": kind, "md5sum": md5, "message_definition": definition}
            header |= {"callerid": caller} if caller else {}
            header |= {"latching": latching} if latching else {}
            self._connections[found] = Connection(found, topic.decode("utf-8", "surrogateescape"), header)
        return found


def read_old(content: bytes, connections: OldConnections) -> tuple[Messages, int]:
    """Return the complete messages at the beginning of `content`, and the offset behind the last record.

    Definitions are stored. Reading ends at the first record of another kind.
    """
    messages = Messages()
    position = 0
    while position < len(content):
        try:
            fields, start, stop = split_record(content, position)
            op = op_of(fields)
            if op == OP_DEFINITION:
                connections.define(fields)
            elif op == OP_MESSAGE:
                time = u32(fields, "sec") * NS + u32(fields, "nsec")
                messages.add(connections.number(fields), time, position, start, stop)
            else:
                break
        except RecordError:
            break
        position = stop
    return messages, position


def record_begins(data: bytes, position: int) -> Iterator[int]:
    """Yield the positions from `position` on at which a record may begin, to continue after a damaged place."""
    found = _BEGINS.search(data, position)
    while found is not None:
        yield found.start()
        found = _BEGINS.search(data, found.start() + 1)
