"""Scanner, which reads a bag from beginning to end without its index, and does not trust any length in it.

It finds all complete messages of bags that were not closed, are cut off or damaged. Memory holds one chunk at a time.
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
    u32,
)
from pyros1.bag.format.version_1_2 import MAX_BEGIN_LENGTH, OldConnections, read_old, record_begins

_LOOSE_SIZE = 1 << 20
"""Number of bytes of messages outside of chunks that are read at a time."""

_SEARCH = 1 << 20
"""Number of bytes searched at a time, and in the first step, since the next record may be near."""
_FIRST_SEARCH = 1 << 12

_MAX_READ_FACTOR = 64
"""Maximum number of times, on average, that the file's bytes are read: each wrong length might claim the whole rest."""
MIN_READ_BUDGET = 64 << 20

_TRUSTED_SIZE = 1 << 16
"""Size in bytes up to which a record other than a chunk is trusted; after a longer one, another record must follow."""


@dataclass(frozen=True)
class Damage:
    """A place in the file that cannot be read.

    Attributes:
        offset: offset in bytes.
        reason: what is wrong there.
    """

    offset: int
    reason: str


@dataclass(frozen=True)
class ScannedChunk:
    """A chunk that the scanner has read.

    Attributes:
        chunk: its place, times and counts.
        header: its header; None for messages outside of chunks.
        content: its content, uncompressed.
        messages: its complete messages, in order.
        defined: the connections in it, by id.
    """

    chunk: Chunk
    header: ChunkHeader | None
    content: bytes
    messages: Messages
    defined: dict[int, Connection]


class Scanner:
    """One pass over a bag.

    Args:
        file: the bag.
        progress: called occasionally with the offset in bytes.

    Attributes:
        connections: connections found so far, by id.
        damages: places that could not be read.
        old: the connections of a bag of version 1.2.

    Raises:
        EncryptedError: the bag is encrypted, and its key is not available.
    """

    def __init__(self, file: BagFile, progress: Callable[[int], object] | None = None) -> None:
        file.unlock()
        self._file = file
        self._progress = progress
        self.connections: dict[int, Connection] = {}
        self.damages: list[Damage] = []
        self.old = OldConnections(self.connections)
        self._definitions = 0  # bytes in connections
        self._read_budget = file.bytes_read + MIN_READ_BUDGET + _MAX_READ_FACTOR * file.size
        self._loose_size = _LOOSE_SIZE

    def chunks(self) -> Iterator[ScannedChunk]:
        """Yield the chunks in the file's order, and messages outside of chunks in pieces."""
        position = self._file.begin
        while position < self._file.size:
            if self._is_exhausted():
                self.damages.append(
                    Damage(position, "there is too much damage, so the rest of the file was not searched")
                )
                return
            if self._progress is not None:
                self._progress(position)
            found, next_position = self._next(position)
            if found is not None and (found.messages or found.defined):
                for connection in found.defined.values():
                    self._define(connection)
                yield found
            del found  # so that only one chunk is in memory
            position = next_position

    def _is_exhausted(self) -> bool:
        return self._file.bytes_read > self._read_budget

    def _next(self, position: int) -> tuple[ScannedChunk | None, int]:
        """Read a record at an offset; return the messages there, and the offset at which to continue."""
        file = self._file
        try:
            if file.cipher is not None and self._in_end_section(position):
                return None, self._end_section()
            fields, data, length = file.record(position)
            op = op_of(fields)
            if op == OP_CHUNK:
                return self._chunk(position, file.chunk_header(position))
            if op in (OP_MESSAGE, OP_DEFINITION) or (op == OP_CONNECTION and not self._in_end_section(position)):
                return self._loose(position)
            if op == OP_CONNECTION:
                connection, next_position = file.connection(position)
                self._define(connection)
                return None, next_position
            if op == OP_INDEX:
                length = self._index_length(fields, length)
            if data + length > file.size:
                raise RecordError("the record's data run past the end of the file")
            self._is_credible(data, length)
        except RecordError as error:
            return None, self._damaged(position, str(error))
        return None, data + length

    def _is_credible(self, data: int, length: int) -> None:
        """Raise RecordError if a record other than a chunk has a wrong length, since it must not skip whole chunks."""
        if length > _TRUSTED_SIZE and data + length < self._file.size:
            self._file.record(data + length)

    def _end_section(self) -> int:
        """Read the end section of an encrypted bag, which has a different form; return the offset behind it."""
        for connection, _ in self._file.end_connections():
            self._define(connection)
        return self._file.size

    def _define(self, connection: Connection) -> None:
        if connection.id in self.connections or len(self.connections) >= MAX_CONNECTIONS:
            return
        self._definitions += sum(map(len, connection.header.values()))
        if self._definitions <= self._file.limit:  # small chunks may hold many large connections
            self.connections[connection.id] = connection

    def _in_end_section(self, position: int) -> bool:
        return 0 < self._file.index_pos <= position

    @staticmethod
    def _index_length(fields: Fields, length: int) -> int:
        """Return the length of an index record's data; recorders of 2010 wrote a wrong one (their count is right)."""
        if fields.get("ver") == b"\1\0\0\0" and len(fields.get("count", b"")) == 4:
            return 12 * u32(fields, "count")
        return length

    def _chunk(self, position: int, header: ChunkHeader) -> tuple[ScannedChunk | None, int]:
        file = self._file
        if header.stored == 0 and header.size == 0:
            return self._unfinished(position, header)
        stored = file.read(header.data, header.trusted_size(file.limit))
        next_position = header.data + len(stored)
        reason = ""
        if len(stored) < header.stored:
            cut = header.data + header.stored > file.size
            reason = "the chunk is cut off" if cut else "the chunk's lengths contradict each other"
        content, messages = b"", Messages()
        defined: dict[int, Connection] = {}
        try:
            check_size(header.size, file.limit)
            if not reason:
                content = decompress(header.compression, file.plain(stored), header.size, file.limit)
                messages, defined = read_content(content)
        except RecordError as error:
            reason = str(error)
        if reason:
            self.damages.append(Damage(position, reason))
            del content, messages
            content, messages, defined = self._keep_chunk(header, stored, header.size)
            next_position = self._trusted_end(position, next_position, cut=len(stored) < header.stored)
        chunk = _summary(position, messages)
        chunk.whole = not reason
        return ScannedChunk(chunk, header, content, messages, defined), next_position

    def _unfinished(self, position: int, header: ChunkHeader) -> tuple[ScannedChunk | None, int]:
        """Return a chunk that the recorder had not finished: its header still says that it is empty."""
        self.damages.append(Damage(position, "the last chunk was not finished"))
        if header.compression == "none":
            return None, header.data  # its messages follow as if they were outside of chunks
        stored = self._file.read(header.data, self._file.limit)
        content, messages, defined = self._keep_chunk(header, stored, self._file.limit)
        chunk = _summary(position, messages)
        chunk.whole = False
        return ScannedChunk(chunk, header, content, messages, defined), self._find_next_record(header.data)

    def _keep_chunk(
        self, header: ChunkHeader, stored: bytes, size: int
    ) -> tuple[bytes, Messages, dict[int, Connection]]:
        """Return the readable part of a damaged chunk."""
        file = self._file
        try:
            content = decompress(header.compression, file.plain(stored, partial=True), size, file.limit, partial=True)
        except RecordError:
            return b"", Messages(), {}
        return content, *read_content(content, partial=True)

    def _trusted_end(self, position: int, end: int, *, cut: bool) -> int:
        """Return where to continue after a damaged chunk: at its end if a record is there, else at the next chunk."""
        if not cut:
            try:
                self._file.record(end)
                return end
            except RecordError:
                if end >= self._file.size:
                    return end
        return self._find_next_record(position + 1)

    def _loose(self, position: int) -> tuple[ScannedChunk | None, int]:
        """Return messages outside of chunks: those of an unfinished chunk, or of a bag of version 1.2."""
        file = self._file
        _, data, length = file.record(position)
        if data + length > file.size:
            return None, self._damaged(position, "the message is cut off, or its length is damaged")
        check_size(length, file.limit)
        self._is_credible(data, length)
        content = file.read(position, max(self._loose_size, data + length - position))
        messages, defined, used = self._split_loose(content)
        # The size of a piece depends on the number of messages in the earlier ones.
        self._loose_size = _LOOSE_SIZE if 2 * used > len(content) else max(_FIRST_SEARCH, self._loose_size // 4)
        if not used:
            return None, self._damaged(position, "the message is cut off")
        chunk = _summary(position, messages)
        chunk.loose = used
        return ScannedChunk(chunk, None, content[:used], messages, defined), position + used

    def _split_loose(self, content: bytes) -> tuple[Messages, dict[int, Connection], int]:
        if self._file.version == 102:
            messages, used = read_old(content, self.old)
            return messages, {}, used
        used = _loose_end(content)
        return *read_content(content[:used], partial=True), used

    def _damaged(self, position: int, reason: str) -> int:
        if self._file.size - position > 0:
            self.damages.append(Damage(position, reason))
        return self._find_next_record(position + 1)

    def _find_next_record(self, position: int) -> int:
        """Return the offset of the next chunk after a damaged place, or else that of the index or the file's end.

        In a bag of version 1.2: the offset of the next message or definition.
        """
        if self._file.version == 102:
            return self._find_next_old_record(position)
        word = b"compression="
        index = self._file.index_pos
        last = index if position < index else self._file.size
        earliest = position  # not the damaged chunk itself again
        size = _FIRST_SEARCH
        while position < self._file.size:
            block = self._file.read(position, size)
            at = block.find(word)
            while at >= 0:
                for before in (16, 8, 17 + 8):  # the field is the second, the first, or after the size
                    start = position + at - before
                    if start >= earliest and (self._is_exhausted() or self._is_chunk(start)):
                        return start
                at = block.find(word, at + 1)
            if len(block) < size:
                break
            position += len(block) - len(word)
            size = min(4 * size, _SEARCH)
        return min(last, self._file.size)

    def _find_next_old_record(self, position: int) -> int:
        size = _FIRST_SEARCH
        while position < self._file.size:
            block = self._file.read(position, size)
            for at in record_begins(block, 0):
                if self._is_exhausted() or self._is_old(position + at):
                    return position + at
            if len(block) < size:
                break
            position += len(block) - MAX_BEGIN_LENGTH
            size = min(4 * size, _SEARCH)
        return self._file.size

    def _is_old(self, position: int) -> bool:
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


def _loose_end(content: bytes) -> int:
    """Return the number of bytes of complete messages and connections at the beginning of `content`."""
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


def _summary(position: int, messages: Messages) -> Chunk:
    times = messages.times
    return Chunk(position, min(times, default=0), max(times, default=0), Counter(messages.conns))
