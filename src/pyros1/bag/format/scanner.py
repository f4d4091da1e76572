"""Reads a bag from beginning to end, without its index and without trusting any length in it.

The scanner finds all complete messages in bags that were not closed, are cut off, or are damaged. Only one chunk is in
memory at a time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from pyros1.bag.format.compression import COMPRESSIONS, check_size, decompress
from pyros1.bag.format.contents import Messages, read_content
from pyros1.bag.format.files import BagFile, Chunk, ChunkHeader
from pyros1.bag.format.records import (
    MAX_CONNECTIONS,
    OP_CHUNK,
    OP_CONNECTION,
    OP_DEFINITION,
    OP_INDEX,
    OP_MESSAGE,
    Connection,
    Fields,
    RecordError,
    op_of,
    split_record,
    u32_field,
)
from pyros1.bag.format.version_1_2 import MAX_BEGIN_LENGTH, OldConnections, find_record_starts, read_old_messages

_LOOSE_READ_SIZE = 1 << 20
"""Number of bytes of messages outside of chunks that are read at a time."""

_MAX_SEARCH_SIZE = 1 << 20
"""Number of bytes searched at a time; fewer at first, since the next record may be near."""
_FIRST_SEARCH_SIZE = 1 << 12

_MAX_READ_FACTOR = 64
"""Maximum number of times that a byte is read on average: without a limit, every wrong length could claim the rest of
the file, which would be read again each time.
"""
MIN_READ_BUDGET = 64 << 20

_TRUSTED_SIZE = 1 << 16
"""Size in bytes up to which a record other than a chunk is trusted; a longer one must be followed by another record."""


@dataclass(frozen=True)
class Damage:
    """A place in the file that cannot be read.

    Attributes:
        offset: offset in bytes.
        reason: why it cannot be read.
    """

    offset: int
    reason: str


@dataclass(frozen=True)
class ScannedChunk:
    """A chunk that the scanner has read.

    Attributes:
        chunk: its offset, times and counts.
        header: its header; None for messages outside of chunks.
        content: its content, uncompressed.
        messages: its complete messages, in order.
        defined_connections: the connections defined in it, by id.
    """

    chunk: Chunk
    header: ChunkHeader | None
    content: bytes
    messages: Messages
    defined_connections: dict[int, Connection]


class Scanner:
    """One pass over a bag.

    Args:
        file: the bag file to read.
        progress: called occasionally with the current offset in bytes.

    Attributes:
        connections: connections found so far, by id.
        damaged_places: places that could not be read.
        old_connections: the connections of a bag of version 1.2.

    Raises:
        EncryptedError: the bag is encrypted, and its key is not available.
    """

    def __init__(self, file: BagFile, progress: Callable[[int], object] | None = None) -> None:
        file.unlock()
        self._file = file
        self._progress = progress
        self.connections: dict[int, Connection] = {}
        self.damaged_places: list[Damage] = []
        self.old_connections = OldConnections(self.connections)
        self._definitions_size = 0  # total size of the connection headers in bytes
        self._read_budget = file.bytes_read + MIN_READ_BUDGET + _MAX_READ_FACTOR * file.size
        self._loose_read_size = _LOOSE_READ_SIZE

    def chunks(self) -> Iterator[ScannedChunk]:
        """Yield the chunks in file order, and messages outside of chunks in pieces."""
        position = self._file.begin
        while position < self._file.size:
            if self._has_exhausted_budget():
                self.damaged_places.append(
                    Damage(position, "there is so much damage that the rest of the file was not searched")
                )
                return
            if self._progress is not None:
                self._progress(position)
            scanned_chunk, next_position = self._next_record(position)
            if scanned_chunk is not None and (scanned_chunk.messages or scanned_chunk.defined_connections):
                for connection in scanned_chunk.defined_connections.values():
                    self._add_connection(connection)
                yield scanned_chunk
            del scanned_chunk  # so that only one chunk is in memory
            position = next_position

    def _has_exhausted_budget(self) -> bool:
        return self._file.bytes_read > self._read_budget

    def _next_record(self, position: int) -> tuple[ScannedChunk | None, int]:
        """Read the record at an offset; return the chunk it contains, or None, and the offset at which to continue."""
        file = self._file
        try:
            if file.cipher is not None and self._is_in_end_section(position):
                return None, self._read_end_section()
            fields, data, length = file.record(position)
            op = op_of(fields)
            if op == OP_CHUNK:
                return self._read_chunk(position, file.chunk_header(position))
            if op in (OP_MESSAGE, OP_DEFINITION) or (op == OP_CONNECTION and not self._is_in_end_section(position)):
                return self._read_outside_chunks(position)
            if op == OP_CONNECTION:
                connection, next_position = file.connection(position)
                self._add_connection(connection)
                return None, next_position
            if op == OP_INDEX:
                length = self._index_length(fields, length)
            if data + length > file.size:
                raise RecordError("the record's data run past the end of the file")
            self._check_length(data, length)
        except RecordError as error:
            return None, self._skip_damage(position, str(error))
        return None, data + length

    def _check_length(self, data: int, length: int) -> None:
        """Raise RecordError if the length of a record other than a chunk seems wrong, since trusting it could skip
        whole chunks.
        """
        if length > _TRUSTED_SIZE and data + length < self._file.size:
            self._file.record(data + length)

    def _read_end_section(self) -> int:
        """Read the end section of an encrypted bag, which has a different format; return the offset after it."""
        for connection, _ in self._file.end_connections():
            self._add_connection(connection)
        return self._file.size

    def _add_connection(self, connection: Connection) -> None:
        if connection.id in self.connections or len(self.connections) >= MAX_CONNECTIONS:
            return
        self._definitions_size += sum(map(len, connection.header.values()))
        if self._definitions_size <= self._file.limit:  # small compressed chunks can hold many large connections
            self.connections[connection.id] = connection

    def _is_in_end_section(self, position: int) -> bool:
        return 0 < self._file.index_pos <= position

    @staticmethod
    def _index_length(fields: Fields, length: int) -> int:
        """Return the length of an index record's data; recorders from 2010 wrote a wrong length but a correct count."""
        if fields.get("ver") == b"\1\0\0\0" and len(fields.get("count", b"")) == 4:
            return 12 * u32_field(fields, "count")
        return length

    def _read_chunk(self, position: int, header: ChunkHeader) -> tuple[ScannedChunk | None, int]:
        file = self._file
        if header.stored_size == 0 and header.size == 0:
            return self._read_unfinished_chunk(position, header)
        stored = file.read(header.data_offset, header.trusted_size(file.limit))
        next_position = header.data_offset + len(stored)
        reason = ""
        if len(stored) < header.stored_size:
            is_cut_off = header.data_offset + header.stored_size > file.size
            reason = "the chunk is cut off" if is_cut_off else "the chunk's lengths contradict each other"
        content, messages = b"", Messages()
        defined_connections: dict[int, Connection] = {}
        try:
            check_size(header.size, file.limit)
            if not reason:
                content = decompress(header.compression, file.decrypt(stored), header.size, file.limit)
                messages, defined_connections = read_content(content)
        except RecordError as error:
            reason = str(error)
        if reason:
            self.damaged_places.append(Damage(position, reason))
            del content, messages
            content, messages, defined_connections = self._salvage_chunk(header, stored, header.size)
            next_position = self._continue_after(position, next_position, is_cut_off=len(stored) < header.stored_size)
        chunk = _make_chunk(position, messages)
        chunk.is_complete = not reason
        return ScannedChunk(chunk, header, content, messages, defined_connections), next_position

    def _read_unfinished_chunk(self, position: int, header: ChunkHeader) -> tuple[ScannedChunk | None, int]:
        """Return the readable part of a chunk that the recorder did not finish: its header still says that the chunk is
        empty.
        """
        self.damaged_places.append(Damage(position, "the last chunk was not finished"))
        if header.compression == "none":
            return None, header.data_offset  # its messages follow as if they were outside of chunks
        stored = self._file.read(header.data_offset, self._file.limit)
        content, messages, defined_connections = self._salvage_chunk(header, stored, self._file.limit)
        chunk = _make_chunk(position, messages)
        chunk.is_complete = False
        return (
            ScannedChunk(chunk, header, content, messages, defined_connections),
            self._find_next_record(header.data_offset),
        )

    def _salvage_chunk(
        self, header: ChunkHeader, stored: bytes, size: int
    ) -> tuple[bytes, Messages, dict[int, Connection]]:
        """Return the readable part of a damaged chunk: its content, messages and connections."""
        file = self._file
        try:
            content = decompress(header.compression, file.decrypt(stored, partial=True), size, file.limit, partial=True)
        except RecordError:
            return b"", Messages(), {}
        return content, *read_content(content, partial=True)

    def _continue_after(self, chunk_pos: int, end: int, *, is_cut_off: bool) -> int:
        """Return the offset at which to continue after a damaged chunk: the chunk's end if another record or the end
        of the file is there, otherwise the offset of the next chunk.
        """
        if not is_cut_off:
            try:
                self._file.record(end)
                return end
            except RecordError:
                if end >= self._file.size:
                    return end
        return self._find_next_record(chunk_pos + 1)

    def _read_outside_chunks(self, position: int) -> tuple[ScannedChunk | None, int]:
        """Read messages outside of chunks, which belong to an unfinished chunk or to a bag of version 1.2.

        Returns:
            As for `_next_record`.
        """
        file = self._file
        _, data, length = file.record(position)
        if data + length > file.size:
            return None, self._skip_damage(position, "the message is cut off, or its length is damaged")
        check_size(length, file.limit)
        self._check_length(data, length)
        content = file.read(position, max(self._loose_read_size, data + length - position))
        messages, defined_connections, used_size = self._parse_loose(content)
        # The size of the next piece depends on how much of this piece could be used.
        self._loose_read_size = (
            _LOOSE_READ_SIZE if 2 * used_size > len(content) else max(_FIRST_SEARCH_SIZE, self._loose_read_size // 4)
        )
        if not used_size:
            return None, self._skip_damage(position, "the message is cut off")
        chunk = _make_chunk(position, messages)
        chunk.loose_size = used_size
        return ScannedChunk(chunk, None, content[:used_size], messages, defined_connections), position + used_size

    def _parse_loose(self, content: bytes) -> tuple[Messages, dict[int, Connection], int]:
        if self._file.version == 102:
            messages, used_size = read_old_messages(content, self.old_connections)
            return messages, {}, used_size
        used_size = _complete_size(content)
        return *read_content(content[:used_size], partial=True), used_size

    def _skip_damage(self, position: int, reason: str) -> int:
        self.damaged_places.append(Damage(position, reason))
        return self._find_next_record(position + 1)

    def _find_next_record(self, position: int) -> int:
        """Return the offset of the next chunk after damage; without one, the offset of the index or the end of the
        file.

        For a bag of version 1.2, look for the next message or definition instead of the next chunk.
        """
        if self._file.version == 102:
            return self._find_next_old_record(position)
        marker = b"compression="
        index_pos = self._file.index_pos
        fallback = index_pos if position < index_pos else self._file.size
        earliest = position  # so that the damaged chunk itself is not found again
        size = _FIRST_SEARCH_SIZE
        while position < self._file.size:
            block = self._file.read(position, size)
            match = block.find(marker)
            while match >= 0:
                for distance in (16, 8, 17 + 8):  # "compression" may follow op, be first, or follow size
                    start = position + match - distance
                    if start >= earliest and (self._has_exhausted_budget() or self._is_chunk(start)):
                        return start
                match = block.find(marker, match + 1)
            if len(block) < size:
                break
            position += len(block) - len(marker)
            size = min(4 * size, _MAX_SEARCH_SIZE)
        return min(fallback, self._file.size)

    def _find_next_old_record(self, position: int) -> int:
        size = _FIRST_SEARCH_SIZE
        while position < self._file.size:
            block = self._file.read(position, size)
            for start in find_record_starts(block, 0):
                if self._has_exhausted_budget() or self._is_old_record(position + start):
                    return position + start
            if len(block) < size:
                break
            position += len(block) - MAX_BEGIN_LENGTH
            size = min(4 * size, _MAX_SEARCH_SIZE)
        return self._file.size

    def _is_old_record(self, position: int) -> bool:
        try:
            fields, data, length = self._file.record(position)
            return op_of(fields) in (OP_MESSAGE, OP_DEFINITION) and data + length <= self._file.size
        except RecordError:
            return False

    def _is_chunk(self, position: int) -> bool:
        try:
            return self._file.chunk_header(position).compression in COMPRESSIONS
        except RecordError:
            return False


def _complete_size(content: bytes) -> int:
    """Return the total size of the complete messages and connections at the beginning of `content`."""
    position = 0
    try:
        while position < len(content):
            fields, _, stop = split_record(content, position)
            if op_of(fields) not in (OP_MESSAGE, OP_CONNECTION):
                break
            position = stop
    except RecordError:
        pass
    return position


def _make_chunk(position: int, messages: Messages) -> Chunk:
    times = messages.times
    return Chunk(position, min(times, default=0), max(times, default=0), Counter(messages.conns))
