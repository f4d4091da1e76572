"""Reads bags of version 1.2 (http://wiki.ros.org/Bags/Format/1.2).

They contain no chunks; each message record contains the names of its topic and type.

Newer recorders wrote a file header at the beginning and an index at the end; older ones wrote neither. The index is not
needed, since one pass over the file finds all messages and definitions.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from pyros1.bag.format.contents import Messages
from pyros1.bag.format.records import (
    MAX_CONNECTIONS,
    NS_PER_S,
    OP_DEFINITION,
    OP_MESSAGE,
    Connection,
    Fields,
    RecordError,
    op_of,
    split_record,
    u32_field,
)

_ConnectionKey = tuple[bytes, bytes, bytes, bytes, bytes]

_RECORD_START_PATTERN = re.compile(rb"...\0...\0(?:callerid|def|latching|md5|nsec|op|sec|topic|type)=", re.DOTALL)
"""Pattern of the beginning of a message or definition record: two lengths below 16 MiB and the name of a field."""

MAX_BEGIN_LENGTH = 17
"""Maximum number of bytes that the pattern matches."""


class OldConnections:
    """Assigns ids to the connections of a bag of version 1.2.

    Args:
        connections: the dict to which they are added: id -> connection.
    """

    def __init__(self, connections: dict[int, Connection]) -> None:
        self._connections = connections
        self._conn_ids: dict[_ConnectionKey, int] = {}
        self._definitions: dict[tuple[bytes, bytes], bytes] = {}

    def add_definition(self, fields: Fields) -> None:
        """Add the definition from a record; raises RecordError if there are too many."""
        definition = fields.get("def", b"")
        if len(self._definitions) >= MAX_CONNECTIONS:
            raise RecordError(f"the bag has more than {MAX_CONNECTIONS} definitions")
        type_name = fields.get("type", b"")
        self._definitions[type_name, fields.get("md5", b"")] = definition
        self._definitions.setdefault((type_name, b""), definition)

    def connection_id(self, fields: Fields) -> int:
        """Return the id of a message's connection, which is added if it is new; raises RecordError if there are too
        many.
        """
        names = ("topic", "type", "md5", "callerid", "latching")
        topic, type_name, md5, caller, latching = (fields.get(name, b"") for name in names)
        key = (topic, type_name, md5, caller, latching)
        conn_id = self._conn_ids.get(key)
        if conn_id is None:
            if len(self._conn_ids) >= MAX_CONNECTIONS:
                raise RecordError(f"the bag has more than {MAX_CONNECTIONS} connections")
            conn_id = self._conn_ids[key] = len(self._conn_ids)
            definitions = self._definitions
            definition = definitions.get((type_name, md5)) or definitions.get((type_name, b""), b"")
            header = {"topic": topic, "type": type_name, "md5sum": md5, "message_definition": definition}
            header |= {"callerid": caller} if caller else {}
            header |= {"latching": latching} if latching else {}
            self._connections[conn_id] = Connection(conn_id, topic.decode("utf-8", "surrogateescape"), header)
        return conn_id


def read_old_messages(content: bytes, connections: OldConnections) -> tuple[Messages, int]:
    """Return the complete messages at the beginning of `content`, and the offset after the last record.

    Definitions are added to `connections`. Reading stops at the first record that is incomplete or of another kind.
    """
    messages = Messages()
    position = 0
    while position < len(content):
        try:
            fields, start, stop = split_record(content, position)
            op = op_of(fields)
            if op == OP_DEFINITION:
                connections.add_definition(fields)
            elif op == OP_MESSAGE:
                time = u32_field(fields, "sec") * NS_PER_S + u32_field(fields, "nsec")
                messages.add(connections.connection_id(fields), time, position, start, stop)
            else:
                break
        except RecordError:
            break
        position = stop
    return messages, position


def find_record_starts(data: bytes, position: int) -> Iterator[int]:
    """Yield the positions from `position` on at which a record may begin, for resuming after damage."""
    match = _RECORD_START_PATTERN.search(data, position)
    while match is not None:
        yield match.start()
        match = _RECORD_START_PATTERN.search(data, match.start() + 1)
