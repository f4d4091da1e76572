"""Messages of a bag in the order of time. What is in memory is the index of the chunks, and the chunks being read."""

from __future__ import annotations

import heapq
import os
import struct
from collections import deque
from collections.abc import Callable, Collection, Iterator
from types import TracebackType
from typing import NamedTuple

from pyros1.bag.codecs import decompress
from pyros1.bag.errors import BagError, UnindexedError
from pyros1.bag.files import BagFile, Chunk, ChunkHeader, Counts
from pyros1.bag.old import OldConnections, walk_old
from pyros1.bag.records import (
    MAX_TIME,
    NS,
    OP_CHUNK_INFO,
    OP_INDEX,
    Connection,
    Message,
    RecordError,
    op_of,
    time_of,
    u32,
    u64,
    walk,
)
from pyros1.bag.scanner import OPEN_CHUNK, Damage, Scanner

_ENTRY = struct.Struct("<III")

MAX_OPEN = 256 << 20
"""Most bytes of chunks that are kept at a time for chunks that overlap in time."""


_NOT_CLOSED = "the bag was not closed, so that it has no index; `pyros1 bag reindex` makes one"


class RawMessage(NamedTuple):
    """A message as it is stored.

    Attributes:
        connection: its publisher's.
        time: receive time in nanoseconds.
        data: its bytes.
    """

    connection: Connection
    time: int
    data: bytes


class BagReader:
    """An open bag.

    Args:
        path: the file.
        unindexed: also read bags without a good index: the file is scanned first, as those of version 1.2 always are.
        progress: called with the offset in bytes while the file is scanned.

    Attributes:
        connections: by id.
        chunks: in the order of the index.
        damages: places that could not be read, if the file was scanned.
        scanned: whether the file was scanned.

    Raises:
        NotABagError: the file is something else.
        UnindexedError: the bag has no index, and `unindexed` is False.
        EncryptedError: it is encrypted, and its key is not to be had.
        OSError: it cannot be opened.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        unindexed: bool = False,
        progress: Callable[[int], object] | None = None,
    ) -> None:
        self.file = BagFile(path)
        self.connections: dict[int, Connection] = {}
        self.chunks: list[Chunk] = []
        self.damages: list[Damage] = []
        self.scanned = False
        self._old: OldConnections | None = None
        try:
            self.file.unlock()
            if self.file.version == 102:
                self._scan(progress)
                if not unindexed:
                    self._check_old()
                return
            try:
                self._read_index()
            except UnindexedError:
                if not unindexed:
                    raise
                self._scan(progress)
        except BaseException:
            self.close()
            raise

    @property
    def path(self) -> str:
        """The file."""
        return self.file.path

    @property
    def start(self) -> int:
        """Earliest time in nanoseconds; 0 without messages."""
        return min((chunk.start for chunk in self.chunks if chunk.counts), default=0)

    @property
    def end(self) -> int:
        """Latest time in nanoseconds; 0 without messages."""
        return max((chunk.end for chunk in self.chunks if chunk.counts), default=0)

    def count(self, connections: Collection[int] | None = None) -> int:
        """Return how many messages there are.

        Args:
            connections: ids of those that count; None means all.
        """
        counts = (item for chunk in self.chunks for item in chunk.counts.items())
        return sum(number for conn, number in counts if connections is None or conn in connections)

    def ids(self, topics: Collection[str]) -> set[int]:
        """Return the ids of the connections of some topics; a leading ``/`` does not matter."""
        wanted = {topic.lstrip("/") for topic in topics}
        return {number for number, connection in self.connections.items() if connection.topic.lstrip("/") in wanted}

    def messages(
        self, connections: Collection[int] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[RawMessage]:
        """Yield messages by time; of the same time, in the file's order.

        Args:
            connections: ids of those wanted; None means all.
            start: only messages of this time or later, in nanoseconds.
            end: only messages of this time or earlier.

        Raises:
            BagError: a chunk cannot be read.
        """
        first, last = 0 if start is None else start, MAX_TIME if end is None else end
        chunks = [chunk for chunk in self.chunks if chunk.end >= first and chunk.start <= last]
        if connections is not None:
            chunks = [chunk for chunk in chunks if not chunk.counts.keys().isdisjoint(connections)]
        pending = deque(sorted(chunks, key=lambda chunk: (chunk.start, chunk.pos)))
        heap: list[tuple[int, int, int, Message, Chunk, Iterator[Message]]] = []
        contents = _Contents(self)
        known = self.connections
        while pending or heap:
            while pending and (not heap or pending[0].start <= heap[0][0]):
                chunk = pending.popleft()
                content, found = self.content(chunk)
                entries = iter(sorted(self._chosen(found, connections, first, last), key=_by_time))
                message = next(entries, None)
                if message is not None:
                    contents.put(chunk, content)
                    heapq.heappush(heap, (message.time, chunk.pos, message.offset, message, chunk, entries))
            if not heap:
                continue
            time, pos, _, message, chunk, entries = heap[0]
            content = contents.get(chunk)
            if len(heap) == 1:
                # The usual case, chunks one after another: no need to sort.
                limit = pending[0].start if pending else MAX_TIME + 1
                following: Message | None = message
                while following is not None and following.time < limit:
                    yield RawMessage(known[following.conn], following.time, content[following.start : following.end])
                    following = next(entries, None)
                if following is message:
                    yield RawMessage(known[message.conn], time, content[message.start : message.end])
                    following = next(entries, None)
            else:
                yield RawMessage(known[message.conn], time, content[message.start : message.end])
                following = next(entries, None)
            if following is None:
                heapq.heappop(heap)
                contents.drop(chunk)
            else:
                heapq.heapreplace(heap, (following.time, pos, following.offset, following, chunk, entries))

    def times(self) -> Iterator[tuple[int, int]]:
        """Yield connection id and time, in nanoseconds, of every message, in no certain order.

        Where there is an index only that is read, which takes no decompressing.

        Raises:
            BagError: a chunk cannot be read.
        """
        for chunk in self.chunks:
            times = None if self.scanned else self._indexed_times(chunk)
            if times is None:
                times = [(message.conn, message.time) for message in self.content(chunk)[1]]
            yield from times

    def _indexed_times(self, chunk: Chunk) -> list[tuple[int, int]] | None:
        """Times from the index records behind a chunk; None if they do not hold what the chunk info says."""
        header = self.header(chunk)
        position = header.data + header.stored
        times: list[tuple[int, int]] = []
        counts = dict(chunk.counts)
        try:
            for _ in counts:
                fields, start, _ = self.file.record(position)
                conn, count = u32(fields, "conn"), u32(fields, "count")
                if op_of(fields) != OP_INDEX or count != counts.get(conn):
                    return None
                data = self.file.read(start, 12 * count)
                if len(data) < 12 * count:
                    return None
                times += [(conn, secs * NS + nsecs) for secs, nsecs, _ in _ENTRY.iter_unpack(data)]
                position = start + 12 * count
        except RecordError:
            return None
        return times

    def headers(self) -> Iterator[ChunkHeader]:
        """Yield the headers of all chunks; of many in a moment, since the system is told before what will be read.

        Raises:
            BagError: one cannot be read.
        """
        self.file.expect(chunk.pos for chunk in self.chunks)
        return map(self.header, self.chunks)

    def header(self, chunk: Chunk) -> ChunkHeader:
        """Return a chunk's header; of messages outside of chunks, one that fits.

        Raises:
            BagError: it cannot be read.
        """
        if chunk.loose:
            return ChunkHeader("none", chunk.loose, chunk.pos, chunk.loose)
        try:
            return self.file.chunk_header(chunk.pos)
        except RecordError as error:
            raise self._damaged(chunk, str(error)) from None

    def content(self, chunk: Chunk) -> tuple[bytes, list[Message]]:
        """Return a chunk's content, and its messages in the file's order.

        Raises:
            BagError: it cannot be read.
        """
        header = self.header(chunk)
        stored = self.file.read(header.data, header.sane if chunk.whole or header.stored else OPEN_CHUNK)
        try:
            if chunk.loose:
                return stored, self._loose(stored)
            if chunk.whole and len(stored) < header.stored:
                cut = header.data + header.stored > self.file.size
                raise RecordError(
                    "the chunk runs past the end of the file" if cut else "the chunk's lengths contradict each other"
                )
            partial = not chunk.whole
            stored = self.file.plain(stored, partial=partial)
            content = decompress(header.compression, stored, header.size or OPEN_CHUNK, partial=partial)
            found = [record for record in walk(content, partial=partial) if isinstance(record, Message)]
        except RecordError as error:
            raise self._damaged(chunk, str(error)) from None
        return content, found

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def __enter__(self) -> BagReader:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _loose(self, stored: bytes) -> list[Message]:
        if self._old is not None:
            return [message for message, _ in walk_old(stored, self._old) if message is not None]
        return [record for record in walk(stored, partial=True) if isinstance(record, Message)]

    def _chosen(
        self, found: list[Message], connections: Collection[int] | None, first: int, last: int
    ) -> Iterator[Message]:
        wanted = self.connections.keys() if connections is None else connections
        for message in found:
            if message.conn in wanted and first <= message.time <= last:
                yield message

    def _damaged(self, chunk: Chunk, reason: str) -> BagError:
        return BagError(self.path, f"{reason}; `pyros1 bag reindex` saves what can be read", chunk.pos)

    # The index -----------------------------------------------------------------------------------------------------

    def _read_index(self) -> None:
        file = self.file
        if file.index_pos == 0:
            raise UnindexedError(self.path, _NOT_CLOSED)
        position = file.index_pos
        try:
            if position >= file.size and u32(file.header, "conn_count") + u32(file.header, "chunk_count"):
                raise RecordError(f"the file has {file.size} bytes, and its index should be at {position}")
            for _ in range(u32(file.header, "conn_count")):
                connection, position = file.connection(position)
                self.connections[connection.id] = connection
            for _ in range(u32(file.header, "chunk_count")):
                position = self._read_chunk_info(position)
        except RecordError as error:
            what = "the file is cut off" if position >= file.size else f"the index is damaged at byte {position}"
            raise UnindexedError(self.path, f"{what} ({error}); `pyros1 bag reindex` makes a new index") from None

    def _check_old(self) -> None:
        """Raise UnindexedError if a 1.2 bag is not whole."""
        if self.file.header and self.file.index_pos == 0:
            raise UnindexedError(self.path, _NOT_CLOSED)
        if self.file.index_pos > self.file.size:
            raise UnindexedError(self.path, "the file is cut off; `pyros1 bag reindex` saves what can be read")
        for damage in self.damages:
            raise UnindexedError(
                self.path, f"{damage.reason}; `pyros1 bag reindex` saves what can be read", damage.offset
            )

    def _read_chunk_info(self, position: int) -> int:
        fields, start, length = self.file.record(position)
        if op_of(fields) != OP_CHUNK_INFO:
            raise RecordError("another record was expected")
        data = self.file.read(start, length)
        if len(data) != length:
            raise RecordError("the record is cut off")
        self.chunks.append(_chunk_info(fields, data))
        return start + length

    def _scan(self, progress: Callable[[int], object] | None) -> None:
        self.chunks, self.connections = [], {}
        scanner = Scanner(self.file, progress)
        for found in scanner.chunks():
            if found.messages:
                self.chunks.append(found.chunk)
        self.connections = scanner.connections
        self.damages = scanner.damages
        self.scanned = True
        if self.file.version == 102:
            self._old = scanner.old


class _Contents:
    """The contents of the chunks being read. If too many overlap in time, the longest unused are read again."""

    def __init__(self, reader: BagReader) -> None:
        self._reader = reader
        self._held: dict[int, bytes] = {}
        self._size = 0

    def put(self, chunk: Chunk, content: bytes) -> None:
        self._held[chunk.pos] = content
        self._size += len(content)
        while self._size > MAX_OPEN and len(self._held) > 1:
            self._size -= len(self._held.pop(next(iter(self._held))))

    def get(self, chunk: Chunk) -> bytes:
        content = self._held.pop(chunk.pos, None)
        if content is None:
            content, _ = self._reader.content(chunk)
            self.put(chunk, content)
        else:
            self._held[chunk.pos] = content  # as the last one
        return content

    def drop(self, chunk: Chunk) -> None:
        self._size -= len(self._held.pop(chunk.pos, b""))


def _by_time(message: Message) -> int:
    return message.time


def _chunk_info(fields: dict[str, bytes], data: bytes) -> Chunk:
    count = u32(fields, "count")
    if u32(fields, "ver") != 1 or len(data) != 8 * count:
        raise RecordError("the chunk info is malformed")
    return Chunk(u64(fields, "chunk_pos"), time_of(fields, "start_time"), time_of(fields, "end_time"), Counts(data))
