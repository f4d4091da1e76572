"""The records of bag files (https://wiki.ros.org/Bags/Format/2.0): bytes to values and back. Does no I/O.

A record is a header of named fields followed by data, each preceded by its length::

    u32 header length, repeated (u32 field length, name=value), u32 data length, data

Lengths come from a file that may be damaged, so each is checked against the available bytes before it is used.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

MAGIC_20 = b"#ROSBAG V2.0\n"

FIRST_LINE_PATTERN = re.compile(rb"#ROS[^\n]{0,32}? V(\d)\.(\d)\r?\n")
"""Pattern of the first line in all versions; before 2.0, recorders wrote another word instead of ``BAG``."""

OP_DEFINITION = 0x01
OP_MESSAGE = 0x02
OP_BAG = 0x03
OP_INDEX = 0x04
OP_CHUNK = 0x05
OP_CHUNK_INFO = 0x06
OP_CONNECTION = 0x07

BAG_HEADER_SIZE = 4096
"""Size in bytes of the bag header's fields and padding; tools rewrite it in place, so all must use the same size."""

MAX_HEADER_SIZE = 1 << 24
"""Maximum size of a record header in bytes; in version 1.2, it may contain a message definition."""

RECORD_OVERHEAD = 46
"""Size in bytes of a message's record without the message."""

MESSAGE_HEADER_PARTS = (b"\x04\0\0\0op=\x02\x09\0\0\0conn=", b"\x0d\0\0\0time=")
"""Bytes before and after the connection id in the message headers that pyros1 writes."""

MAX_CONNECTIONS = 1 << 16
"""Maximum number of connections. In memory, each can take a thousand times its size in a compressed chunk."""

_MAX_FIELDS = 4096
"""Maximum number of fields in a header. Small fields take twenty times their size in memory."""

NS_PER_S = 1_000_000_000
"""Nanoseconds per second."""
MAX_TIME = (1 << 32) * NS_PER_S - 1
"""Latest time that can be stored in a record, in nanoseconds."""

Fields = dict[str, bytes]

U32 = struct.Struct("<I")
U64 = struct.Struct("<Q")
_TIME = struct.Struct("<II")


class RecordError(ValueError):
    """The bytes are not a valid record; the message says why."""


class LimitError(RecordError):
    """The record is larger than the limit; the message says how to raise the limit."""


class Message(NamedTuple):
    """Position of a message in a chunk.

    Attributes:
        conn: id of its connection.
        time: receive time in nanoseconds.
        offset: offset of its record in the chunk.
        start: offset of its first byte in the chunk.
        end: offset after its last byte in the chunk.
    """

    conn: int
    time: int
    offset: int
    start: int
    end: int


@dataclass(frozen=True)
class Connection:
    """A connection: one publisher on one topic.

    Attributes:
        id: its id in the bag.
        topic: name of the topic, exactly as recorded.
        header: all fields of the connection header, as recorded.
    """

    id: int
    topic: str
    header: Mapping[str, bytes] = field(repr=False)  # its message definition would fill the screen

    def text(self, name: str, default: str = "") -> str:
        """Return a field of the header as a string; bytes that are not UTF-8 become surrogate escapes."""
        value = self.header.get(name)
        return default if value is None else value.decode("utf-8", "surrogateescape")

    @property
    def type(self) -> str:
        """Type of the messages, ``package/Type``."""
        return self.text("type")

    @property
    def md5sum(self) -> str:
        """The type's md5 sum."""
        return self.text("md5sum")

    @property
    def definition(self) -> str:
        """The type's definition, followed by the definitions of the types that it uses."""
        return self.text("message_definition")

    @property
    def callerid(self) -> str:
        """Name of the publisher; empty if not recorded."""
        return self.text("callerid")

    @property
    def latching(self) -> bool:
        """Whether the publisher latched its messages."""
        return self.text("latching") == "1"


def parse_fields(data: bytes) -> Fields:
    """Return the fields of a header.

    Raises:
        RecordError: the fields are malformed.
    """
    fields: Fields = {}
    position, end = 0, len(data)
    while position < end:
        if end - position < 4:
            raise RecordError("stray bytes after the header's fields")
        (size,) = U32.unpack_from(data, position)
        position += 4
        if len(fields) >= _MAX_FIELDS:
            raise RecordError(f"the header has more than {_MAX_FIELDS} fields")
        name, separator, value = data[position : position + size].partition(b"=")
        if size > end - position or not separator:
            raise RecordError("a header field runs past the header's end, or has no '='")
        fields[name.decode("utf-8", "surrogateescape")] = value
        position += size
    return fields


def make_fields(fields: Mapping[str, bytes]) -> bytes:
    """Return a header's bytes, without their length."""
    parts = (name.encode("utf-8", "surrogateescape") + b"=" + value for name, value in fields.items())
    return b"".join(U32.pack(len(part)) + part for part in parts)


def make_record(fields: Mapping[str, bytes], data: bytes | bytearray = b"") -> bytes:
    """Return a record's bytes."""
    header = make_fields(fields)
    return U32.pack(len(header)) + header + U32.pack(len(data)) + data


def op_of(fields: Mapping[str, bytes]) -> int:
    """Return a record's op code.

    Raises:
        RecordError: the record has no op code.
    """
    op = fields.get("op", b"")
    if len(op) != 1:
        raise RecordError("the record has no op code")
    return op[0]


def u32_field(fields: Mapping[str, bytes], name: str) -> int:
    """Return the value of a u32 field.

    Raises:
        RecordError: the field is missing, or has another size.
    """
    return _unpack_field(fields, name, U32)


def u64_field(fields: Mapping[str, bytes], name: str) -> int:
    """Return the value of a u64 field; raises the same errors as :func:`u32_field`."""
    return _unpack_field(fields, name, U64)


def time_of(fields: Mapping[str, bytes], name: str = "time") -> int:
    """Return the value of a time field in nanoseconds; raises the same errors as :func:`u32_field`."""
    value = fields.get(name, b"")
    if len(value) != 8:
        raise RecordError(f"the record has no field {name} of 8 bytes")
    secs, nsecs = _TIME.unpack(value)
    return int(secs) * NS_PER_S + int(nsecs)


def pack_time(time: int) -> bytes:
    """Return the bytes of a time in nanoseconds."""
    return _TIME.pack(*divmod(time, NS_PER_S))


def _unpack_field(fields: Mapping[str, bytes], name: str, number_format: struct.Struct) -> int:
    value = fields.get(name, b"")
    if len(value) != number_format.size:
        raise RecordError(f"the record has no field {name} of {number_format.size} bytes")
    number: int = number_format.unpack(value)[0]
    return number


def make_bag_header(
    index_pos: int = 0, connections: int = 0, chunks: int = 0, extra_fields: Mapping[str, bytes] | None = None
) -> bytes:
    """Return the bag header's record; `index_pos` is 0 if the bag is not closed.

    Args:
        extra_fields: additional fields, for an encrypted bag.

    Raises:
        RecordError: the fields are too long.
    """
    header = make_fields({
        "op": bytes([OP_BAG]),
        "index_pos": U64.pack(index_pos),
        "conn_count": U32.pack(connections),
        "chunk_count": U32.pack(chunks),
        **(extra_fields or {}),
    })  # fmt: skip
    padding = BAG_HEADER_SIZE - len(header)
    if padding < 0:
        raise RecordError(f"the bag header would need {len(header)} bytes, more than {BAG_HEADER_SIZE}")
    return U32.pack(len(header)) + header + U32.pack(padding) + b" " * padding


def make_connection_record(connection: Connection, encrypt: Callable[[bytes], bytes] | None = None) -> bytes:
    """Return the record of a connection.

    Args:
        encrypt: encrypts its header and its data, as in the end section of encrypted bags.
    """
    fields = {
        "op": bytes([OP_CONNECTION]),
        "conn": U32.pack(connection.id),
        "topic": connection.topic.encode("utf-8", "surrogateescape"),
    }
    parts = (make_fields(fields), make_fields(connection.header))
    return b"".join(U32.pack(len(part)) + part for part in (parts if encrypt is None else map(encrypt, parts)))


def parse_connection(fields: Fields, data: bytes) -> Connection:
    """Return the connection from a record's fields and data; raises RecordError if a field is missing or malformed."""
    topic = fields.get("topic", b"").decode("utf-8", "surrogateescape")
    header = parse_fields(data)
    for name in ("type", "md5sum", "message_definition"):
        if name not in header:
            raise RecordError(f"the connection's header has no field {name}")
    return Connection(u32_field(fields, "conn"), topic, header)


def message_record_prefix(conn: int) -> bytes:
    """Return the beginning of a message's record, up to and not including the time."""
    return U32.pack(38) + MESSAGE_HEADER_PARTS[0] + U32.pack(conn) + MESSAGE_HEADER_PARTS[1]


def split_record(data: bytes, position: int) -> tuple[Fields, int, int]:
    """Return the fields of the record at a position, and the start and end of its data.

    Raises:
        RecordError: the record is not complete.
    """
    end = len(data)
    if end - position < 8:
        raise RecordError("the record is cut off")
    (size,) = U32.unpack_from(data, position)
    start = position + 4 + size
    if start + 4 > end:
        raise RecordError("the record's header runs past the end")
    fields = parse_fields(data[position + 4 : start])
    (length,) = U32.unpack_from(data, start)
    if start + 4 + length > end:
        raise RecordError("the record's data run past the end")
    return fields, start + 4, start + 4 + length
