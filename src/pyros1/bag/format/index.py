"""The index of a bag: connections and chunks in the end section, and the index records after each chunk."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from pyros1.bag.errors import UnindexedError
from pyros1.bag.format.files import BagFile, Chunk, ChunkHeader, Counts
from pyros1.bag.format.records import (
    OP_CHUNK_INFO,
    OP_INDEX,
    RECORD_OVERHEAD,
    Connection,
    RecordError,
    op_of,
    time_of,
    u32_field,
    u64_field,
)
from pyros1.bag.format.scanner import Damage

INDEX_ENTRY = struct.Struct("<III")
"""A message's time in seconds and nanoseconds, and its offset in the chunk's content."""

_NOT_CLOSED = "the bag has no index (it was not closed); `pyros1 bag reindex` makes one"


def read_index(file: BagFile) -> tuple[dict[int, Connection], list[Chunk]]:
    """Return the connections by id, and the chunks in index order.

    Raises:
        UnindexedError: the bag has no index, or the index is damaged.
    """
    if file.index_pos == 0:
        raise UnindexedError(file.path, _NOT_CLOSED)
    connections: dict[int, Connection] = {}
    chunks: list[Chunk] = []
    position = file.index_pos
    try:
        if position >= file.size and u32_field(file.header, "conn_count") + u32_field(file.header, "chunk_count"):
            raise RecordError(f"the file has {file.size} bytes, but its index should be at byte {position}")
        for connection, position in file.end_connections():  # noqa: B007 - the last position is used
            connections[connection.id] = connection
        for _ in range(u32_field(file.header, "chunk_count")):
            chunk, position = _read_chunk_info(file, position)
            chunks.append(chunk)
        if len({chunk.pos for chunk in chunks}) < len(chunks):
            raise RecordError("it lists a chunk twice")
    except RecordError as error:
        problem = "the file is cut off" if position >= file.size else f"the index is damaged at byte {position}"
        raise UnindexedError(file.path, f"{problem} ({error}); `pyros1 bag reindex` makes a new index") from None
    return connections, chunks


def check_version_1_2(file: BagFile, damaged_places: Iterable[Damage]) -> None:
    """Raise UnindexedError if a bag of version 1.2 is incomplete, judging by the damage found in it; the error
    reports only the first damaged place.
    """
    if file.header and file.index_pos == 0:
        raise UnindexedError(file.path, _NOT_CLOSED)
    if file.index_pos > file.size:
        raise UnindexedError(
            file.path, "the file is cut off; `pyros1 bag reindex` recovers everything that can be read"
        )
    for damage in damaged_places:
        raise UnindexedError(
            file.path, f"{damage.reason}; `pyros1 bag reindex` recovers everything that can be read", damage.offset
        )


def entry_ranges(file: BagFile, chunk: Chunk, header: ChunkHeader) -> list[tuple[int, int, int]] | None:
    """Return (connection id, file offset, size in bytes) of the entries in each index record after a chunk.

    Return None if the index records contradict the chunk info or the size of the content.
    """
    position = header.data_offset + header.stored_size
    ranges: list[tuple[int, int, int]] = []
    counts = dict(chunk.counts)
    if sum(counts.values()) * RECORD_OVERHEAD > min(header.size, file.limit):
        return None
    try:
        for _ in counts:
            fields, start, _ = file.record(position)
            conn, count = u32_field(fields, "conn"), u32_field(fields, "count")
            size = INDEX_ENTRY.size * count
            if op_of(fields) != OP_INDEX or count != counts.get(conn) or start + size > file.size:
                return None
            ranges.append((conn, start, size))
            position = start + size
    except RecordError:
        return None
    return ranges


def _read_chunk_info(file: BagFile, position: int) -> tuple[Chunk, int]:
    """Return the chunk from a chunk info record, and the offset after the record."""
    fields, begin, length = file.record(position)
    if op_of(fields) != OP_CHUNK_INFO:
        raise RecordError("this is not the expected kind of record")
    data = file.read(begin, length)
    if len(data) != length:
        raise RecordError("the record is cut off")
    count = u32_field(fields, "count")
    if u32_field(fields, "ver") != 1 or length != 8 * count:
        raise RecordError("the chunk info is malformed")
    start, end = time_of(fields, "start_time"), time_of(fields, "end_time")
    if count and start > end:
        raise RecordError("the end time of a chunk is before its start time")
    return Chunk(u64_field(fields, "chunk_pos"), start, end, Counts(data)), begin + length
