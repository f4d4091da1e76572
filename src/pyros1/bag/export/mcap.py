"""The records of MCAP files (https://mcap.dev/spec): bytes to values and back. Does no I/O.

A file is ``magic, records, magic``; a record is ``u8 op, u64 length, content``. Lengths come from a file that may be
damaged, so each is checked against the available bytes before it is used.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from pyros1.bag.format.records import U32, U64, RecordError

MAGIC = b"\x89MCAP0\r\n"

OP_HEADER = 0x01
OP_FOOTER = 0x02
OP_SCHEMA = 0x03
OP_CHANNEL = 0x04
OP_MESSAGE = 0x05
OP_CHUNK = 0x06
OP_MESSAGE_INDEX = 0x07
OP_CHUNK_INDEX = 0x08
OP_STATISTICS = 0x0B
OP_SUMMARY_OFFSET = 0x0E
OP_DATA_END = 0x0F

ROS1_ENCODING = "ros1"
"""Name of the ROS 1 message encoding."""
ROS1_SCHEMA = "ros1msg"
"""Name of the ROS 1 definition encoding; the profile is called ``ros1`` like the message encoding."""

U16 = struct.Struct("<H")
RECORD_HEADER = struct.Struct("<BQ")
"""The header of a record: op and length."""
MESSAGE_HEADER = struct.Struct("<HIQQ")
"""The header of a message's content: channel, sequence, time of recording, time of publishing."""

Buffer = bytes | bytearray | memoryview


class Schema(NamedTuple):
    """A message type.

    Attributes:
        id: its number in the file, not 0.
        name: name of the type.
        encoding: encoding of its definition.
        data: its definition.
    """

    id: int
    name: str
    encoding: str
    data: bytes


class Channel(NamedTuple):
    """A stream of messages on a topic.

    Attributes:
        id: its number in the file.
        schema_id: id of the type; 0 for none.
        topic: its topic.
        encoding: encoding of its messages.
        metadata: additional fields.
    """

    id: int
    schema_id: int
    topic: str
    encoding: str
    metadata: Mapping[str, str]


class ChunkIndex(NamedTuple):
    """The index entry of a chunk.

    Attributes:
        start: earliest time in it, in nanoseconds.
        end: latest time in it.
        offset: offset of its record in the file.
        length: length of its record in bytes.
        compression: compression of its content.
        stored_size: size of its content in the file, in bytes.
        size: size of its content, uncompressed, in bytes.
    """

    start: int
    end: int
    offset: int
    length: int
    compression: str
    stored_size: int
    size: int


class Cursor:
    """Reads the fields of a record one after the other.

    Args:
        data: the record's content.
    """

    def __init__(self, data: Buffer) -> None:
        self._data = memoryview(data)
        self._position = 0

    def __bool__(self) -> bool:
        return self._position < len(self._data)

    def read_bytes(self, size: int) -> memoryview:
        """Read and return `size` bytes.

        Raises:
            RecordError: there are too few bytes; the other methods raise this as well.
        """
        begin, end = self._position, self._position + size
        if end > len(self._data):
            raise RecordError("a field of the record runs past its end")
        self._position = end
        return self._data[begin:end]

    def read_number(self, number_format: struct.Struct) -> int:
        """Read a number in the given format."""
        value: int = number_format.unpack(self.read_bytes(number_format.size))[0]
        return value

    def read_block(self) -> memoryview:
        """Read and return bytes that are preceded by their length."""
        return self.read_bytes(self.read_number(U32))

    def read_string(self) -> str:
        """Read and return a string; bytes that are not UTF-8 become surrogate escapes."""
        return bytes(self.read_block()).decode("utf-8", "surrogateescape")

    def read_map(self) -> dict[str, str]:
        """Read and return a map from strings to strings."""
        entries = Cursor(self.read_block())
        result = {}
        while entries:
            name = entries.read_string()
            result[name] = entries.read_string()
        return result


def parse_schema(content: Buffer) -> Schema:
    """Return the message type from a record; raises RecordError if it is malformed, like the functions below."""
    cursor = Cursor(content)
    return Schema(cursor.read_number(U16), cursor.read_string(), cursor.read_string(), bytes(cursor.read_block()))


def parse_channel(content: Buffer) -> Channel:
    """Return the channel from a record."""
    cursor = Cursor(content)
    return Channel(
        cursor.read_number(U16), cursor.read_number(U16), cursor.read_string(), cursor.read_string(), cursor.read_map()
    )


def parse_chunk_index(content: Buffer) -> ChunkIndex:
    """Return the index entry from a chunk index record."""
    cursor = Cursor(content)
    start, end, offset, length = (cursor.read_number(U64) for _ in range(4))
    cursor.read_block()
    cursor.read_number(U64)
    return ChunkIndex(
        start, end, offset, length, cursor.read_string(), cursor.read_number(U64), cursor.read_number(U64)
    )


def make_chunk_index(content: Buffer, offset: int, size: int) -> ChunkIndex:
    """Return the index entry that a chunk should have.

    Args:
        content: content of its record.
        offset: offset of its record in the file.
        size: size of its content, uncompressed, in bytes.
    """
    cursor = Cursor(content)
    start, end = cursor.read_number(U64), cursor.read_number(U64)
    cursor.read_bytes(12)
    return ChunkIndex(
        start, end, offset, RECORD_HEADER.size + len(content), cursor.read_string(), cursor.read_number(U64), size
    )


def check_index(index: Sequence[ChunkIndex], chunks: Mapping[int, ChunkIndex], limit: int) -> None:
    """Raise RecordError if an index does not match the chunks, or too many chunks overlap in time.

    Args:
        index: the entries of the index.
        chunks: offset -> the index entry that the chunk there should have.
        limit: maximum total size in bytes of chunks that overlap in time, since a reader keeps all of them in memory.
    """
    changes = []
    for entry in index:
        if chunks.get(entry.offset) != entry:
            raise RecordError(f"the index is wrong about the chunk at byte {entry.offset}")
        changes += [(entry.start, 0, entry.size), (max(entry.start, entry.end), 1, -entry.size)]
    if len({entry.offset for entry in index}) < len(index):
        raise RecordError("the index lists a chunk twice")
    open_bytes = 0
    for _, _, size_change in sorted(changes):
        open_bytes += size_change
        if open_bytes > limit:
            raise RecordError(
                f"chunks that overlap in time hold {open_bytes} bytes together; the limit is {limit} "
                "(--chunk-limit MIB raises it, if you trust the file)"
            )


def iter_records(content: Buffer) -> Iterator[tuple[int, memoryview]]:
    """Yield the op and content of each record in a chunk's uncompressed content."""
    cursor = Cursor(content)
    while cursor:
        op, size = RECORD_HEADER.unpack(cursor.read_bytes(RECORD_HEADER.size))
        yield op, cursor.read_bytes(size)


def pack_string(text: str) -> bytes:
    """Return a string's bytes. Surrogate escapes become question marks, since MCAP's strings must be UTF-8."""
    return pack_block(text.encode("utf-8", "replace"))


def pack_block(data: bytes) -> bytes:
    """Return bytes preceded by their length."""
    return U32.pack(len(data)) + data


def pack_map(packed_elements: Iterable[bytes]) -> bytes:
    """Return the bytes of a map or an array whose elements are already packed."""
    return pack_block(b"".join(packed_elements))


def pack_record(op: int, *parts: bytes) -> bytes:
    """Return a record's bytes."""
    return b"".join((RECORD_HEADER.pack(op, sum(map(len, parts))), *parts))


def pack_schema(schema: Schema) -> bytes:
    """Return the record of a message type."""
    texts = (pack_string(schema.name), pack_string(schema.encoding))
    return pack_record(OP_SCHEMA, U16.pack(schema.id), *texts, pack_block(schema.data))


def pack_channel(channel: Channel) -> bytes:
    """Return the record of a channel."""
    numbers = U16.pack(channel.id) + U16.pack(channel.schema_id)
    texts = (pack_string(channel.topic), pack_string(channel.encoding))
    metadata = pack_map(pack_string(name) + pack_string(value) for name, value in channel.metadata.items())
    return pack_record(OP_CHANNEL, numbers, *texts, metadata)


def pack_header(profile: str, library: str) -> bytes:
    """Return the first record of a file."""
    return pack_record(OP_HEADER, pack_string(profile), pack_string(library))


def pack_summary_offset(op: int, start: int, size: int) -> bytes:
    """Return a summary offset record: where the summary's records with a given op begin, and their total size."""
    return pack_record(OP_SUMMARY_OFFSET, bytes([op]), U64.pack(start), U64.pack(size))
