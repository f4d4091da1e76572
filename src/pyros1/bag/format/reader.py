"""Reader of a bag's messages in order of time. Memory holds the index of the chunks, and the chunks being read."""

from __future__ import annotations

import heapq
import os
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from types import TracebackType
from typing import IO, TYPE_CHECKING, Any, NamedTuple

from pyros1.bag.errors import BagError, UnindexedError
from pyros1.bag.format.compression import check_size, decompress
from pyros1.bag.format.contents import Messages, read_content
from pyros1.bag.format.files import BagFile, Chunk, ChunkHeader
from pyros1.bag.format.index import ENTRY, check_old, entry_places, read_index
from pyros1.bag.format.records import (
    MAX_TIME,
    NS,
    Connection,
    LimitError,
    RecordError,
)
from pyros1.bag.format.scanner import Damage, Scanner
from pyros1.bag.format.version_1_2 import OldConnections, read_old

if TYPE_CHECKING:
    from pyros1.bag.format.writer import BagWriter

MAX_OPEN = 256 << 20
"""Maximum number of bytes of chunks in memory at a time, for chunks that overlap in time."""


class RawMessage(NamedTuple):
    """A stored message.

    Attributes:
        connection: the publisher's connection.
        time: receive time in nanoseconds.
        data: its bytes.
    """

    connection: Connection
    time: int
    data: bytes


class PlacedMessage(NamedTuple):
    """A stored message and its place.

    Attributes:
        connection, time, data: as in `RawMessage`.
        place: offset of its chunk in the file, and of its record in the chunk's content.
    """

    connection: Connection
    time: int
    data: bytes
    place: tuple[int, int]


class Entry(NamedTuple):
    """A message in the index.

    Attributes:
        conn: id of its connection.
        time: receive time in nanoseconds.
        place: as in `PlacedMessage`.
    """

    conn: int
    time: int
    place: tuple[int, int]


class BagReader:
    """A bag open for reading.

    Args:
        source: path of the file, or an open binary file, which stays open when this is closed.
        unindexed: whether to also read bags without a valid index: they are scanned first, as those of version 1.2
            always are.
        progress: called with the offset in bytes while the file is scanned.
        chunk_limit: maximum size in bytes of the content of a chunk. None means the value of the environment variable
            ``PYROS1_BAG_CHUNK_LIMIT``, in MiB, or else 256 MiB. For the memory needed, see `pyros1.bag.limits`.
        written: the data written so far into a bag that is not yet closed, instead of the index.

    Attributes:
        connections: connections by id.
        chunks: chunks in the order of the index.
        damages: places that could not be read, if the file was scanned.
        scanned: whether the file was scanned.

    Raises:
        NotABagError: the file is not a bag.
        UnindexedError: the bag has no index, and `unindexed` is False.
        EncryptedError: the bag is encrypted, and its key is not available.
        OSError: the file cannot be opened.
    """

    def __init__(
        self,
        source: str | os.PathLike[str] | IO[bytes],
        *,
        unindexed: bool = False,
        progress: Callable[[int], object] | None = None,
        chunk_limit: int | None = None,
        written: BagWriter | None = None,
    ) -> None:
        self.file = BagFile(source, chunk_limit)
        self.connections: dict[int, Connection] = {}
        self.chunks: list[Chunk] = []
        self.damages: list[Damage] = []
        self.scanned = False
        self._old: OldConnections | None = None
        self._positions: list[int] = []  # those of the chunks in the index, sorted
        try:
            if written is not None:
                self.file.cipher = written.cipher
                self._set_index(dict(written.connections), list(written.chunks))
                return
            self.file.unlock()
            if self.file.version == 102:
                self._scan(progress)
                if not unindexed:
                    check_old(self.file, self.damages)
                return
            try:
                self._set_index(*read_index(self.file))
            except UnindexedError:
                if not unindexed:
                    raise
                self._scan(progress)
        except BaseException:
            self.close()
            raise

    @property
    def path(self) -> str:
        """Path of the file."""
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
        """Return the number of messages.

        Args:
            connections: ids of the connections to count; None means all.
        """
        counts = (item for chunk in self.chunks for item in chunk.counts.items())
        return sum(number for conn, number in counts if connections is None or conn in connections)

    def ids(self, topics: Collection[str]) -> set[int]:
        """Return the ids of the connections of some topics; a leading ``/`` matters only if the bag has both names."""
        recorded = {connection.topic for connection in self.connections.values()}
        exact = recorded.intersection(topics)
        others = {topic.lstrip("/") for topic in topics if topic not in exact}
        return {
            number
            for number, connection in self.connections.items()
            if connection.topic in exact or connection.topic.lstrip("/") in others
        }

    def messages(
        self,
        connections: Collection[int] | None = None,
        start: int | None = None,
        end: int | None = None,
        *,
        ranks: Mapping[int, int] | None = None,
    ) -> Iterator[RawMessage]:
        """Yield messages in order of time; with the same time, in the file's order.

        Args:
            connections: ids of the wanted connections; None means all.
            start: only messages of this time or later, in nanoseconds.
            end: only messages of this time or earlier.
            ranks: connection id -> its rank among messages of the same time, which are then in the order of their
                ranks; with the same rank, in the file's order.

        Raises:
            BagError: a chunk cannot be read.
        """
        return self._merged(RawMessage, connections, start, end, ranks)

    def placed(
        self,
        connections: Collection[int] | None = None,
        start: int | None = None,
        end: int | None = None,
        *,
        ranks: Mapping[int, int] | None = None,
    ) -> Iterator[PlacedMessage]:
        """Yield messages with their places; arguments, order and errors as for :meth:`messages`."""
        return self._merged(PlacedMessage, connections, start, end, ranks)

    def _merged(
        self,
        make: type[Any],
        connections: Collection[int] | None,
        start: int | None,
        end: int | None,
        ranks: Mapping[int, int] | None,
    ) -> Iterator[Any]:
        first, last = 0 if start is None else start, MAX_TIME if end is None else end
        chunks = [chunk for chunk in self.chunks if chunk.end >= first and chunk.start <= last]
        if connections is not None:
            chunks = [chunk for chunk in chunks if not chunk.counts.keys().isdisjoint(connections)]
        known = self.connections
        pending = deque(sorted(chunks, key=lambda chunk: (chunk.start, chunk.pos)))

        ids = known.keys() if connections is None else known.keys() & set(connections)

        def select(found: Messages) -> Messages:
            if start is not None or end is not None:
                found = found.where(lambda conn, time: conn in ids and first <= time <= last)
            elif not ids >= set(found.conns):
                found = found.where(lambda conn, time: conn in ids)
            return found.by_time(ranks)

        def key(found: Messages, number: int) -> tuple[int, int]:
            return found.times[number], 0 if ranks is None else ranks[found.conns[number]]

        placed = make is PlacedMessage
        heap: list[tuple[tuple[int, int], int, int, Chunk]] = []  # order, position, and number of each chunk's next one
        contents = _ChunkCache(self, select)
        while pending or heap:
            while pending and (not heap or pending[0].start <= heap[0][0][0]):
                chunk = pending.popleft()
                found = contents.get(chunk)[1]
                if found:
                    heapq.heappush(heap, (key(found, 0), chunk.pos, 0, chunk))
                else:
                    contents.drop(chunk)
            if not heap:
                continue
            _, pos, number, chunk = heapq.heappop(heap)
            content, found = contents.get(chunk)
            until = min(heap[0][0][0] if heap else MAX_TIME + 1, pending[0].start if pending else MAX_TIME + 1)
            next_number = bisect_left(found.times, until, number + 1)
            final = next_number - 1
            if final > number and placed:
                for each in found.part(number, final):
                    conn, time, begin, stop = each[:4]
                    yield PlacedMessage(known[conn], time, content[begin:stop], (pos, found.offsets[number]))
                    number += 1
            elif final > number:
                for conn, time, begin, stop in found.part(number, final):
                    yield RawMessage(known[conn], time, content[begin:stop])
            ((conn, time, begin, stop),) = found.part(final, next_number)
            place = ((pos, found.offsets[final]),) if placed else ()
            message = make(known[conn], time, content[begin:stop], *place)
            if next_number < len(found):
                heapq.heappush(heap, (key(found, next_number), pos, next_number, chunk))
            else:
                contents.drop(chunk)
            del content, found  # a large message is alone in its chunk: while it is used, the chunk is not in memory
            yield message
            del message  # nor is the message, while the next one is read

    def at(self, place: tuple[int, int]) -> RawMessage:
        """Return the message at a place; its whole chunk is read for it.

        Raises:
            BagError: there is no message, or its chunk cannot be read.
        """
        pos, offset = place
        for chunk in self.chunks:
            if chunk.pos == pos:
                content, found = self.content(chunk)
                number = bisect_left(found.offsets, offset)
                if number < len(found) and found.offsets[number] == offset:
                    return RawMessage(
                        self.connections[found.conns[number]],
                        found.times[number],
                        content[found.starts[number] : found.ends[number]],
                    )
        raise BagError(self.path, f"there is no message at {offset} in a chunk at {pos}")

    def entries(self) -> Iterator[Entry]:
        """Yield the places of all messages, in no particular order; otherwise as :meth:`times`."""
        for chunk in self.chunks:
            places = None if self.scanned else entry_places(self.file, chunk, self.header(chunk))
            if places is None:
                found = self.content(chunk)[1]
                for conn, time, offset in zip(found.conns, found.times, found.offsets, strict=True):
                    yield Entry(conn, time, (chunk.pos, offset))
                continue
            for conn, start, size in places:
                for secs, nsecs, offset in ENTRY.iter_unpack(self.file.read(start, size)):
                    yield Entry(conn, secs * NS + nsecs, (chunk.pos, offset))

    def times(self) -> Iterator[tuple[int, int]]:
        """Return (connection id, time in nanoseconds) of every message, in no particular order.

        Chunks with an index are not decompressed: only the index is read.

        Raises:
            BagError: a chunk cannot be read.
        """
        return ((entry.conn, entry.time) for entry in self.entries())

    def headers(self) -> Iterator[ChunkHeader]:
        """Yield the headers of all chunks, quickly even for many: the system is told in advance what will be read.

        Raises:
            BagError: a header cannot be read.
        """
        self.file.prefetch(chunk.pos for chunk in self.chunks)
        return map(self.header, self.chunks)

    def content_size(self) -> int:
        """Return the size of the bag's content in bytes, before compression."""
        return sum(header.size for header in self.headers())

    def header(self, chunk: Chunk) -> ChunkHeader:
        """Return a chunk's header; for messages outside of chunks, a suitable one.

        Raises:
            BagError: the chunk cannot be read.
        """
        if chunk.loose:
            return ChunkHeader("none", chunk.loose, chunk.pos, chunk.loose)
        try:
            return self.file.chunk_header(chunk.pos)
        except RecordError as error:
            raise self._damaged(chunk, str(error)) from None

    def content(self, chunk: Chunk) -> tuple[bytes, Messages]:
        """Return a chunk's content, and its messages in the file's order.

        Raises:
            BagError: the chunk cannot be read.
        """
        header = self.header(chunk)
        file = self.file
        try:
            check_size(header.size, file.limit)
            self._check_end(chunk, header)
            is_unfinished = not chunk.whole and not header.stored
            stored = file.read(header.data, file.limit if is_unfinished else header.trusted_size(file.limit))
            if chunk.loose:
                return stored, self._read_loose(stored)
            if chunk.whole and len(stored) < header.stored:
                is_cut = header.data + header.stored > file.size
                raise RecordError(
                    "the chunk runs past the end of the file" if is_cut else "the chunk's lengths contradict each other"
                )
            partial = not chunk.whole
            stored = file.plain(stored, partial=partial)
            content = decompress(header.compression, stored, header.size or file.limit, file.limit, partial=partial)
            found, _ = read_content(content, partial=partial)
        except RecordError as error:
            if isinstance(error, LimitError):
                raise BagError(self.path, str(error), chunk.pos) from None
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

    def _check_end(self, chunk: Chunk, header: ChunkHeader) -> None:
        """Raise RecordError if a chunk overlaps the next one: many such chunks could each hold most of the file."""
        next_index = bisect_right(self._positions, chunk.pos)
        if next_index < len(self._positions) and header.data + header.stored > self._positions[next_index]:
            raise RecordError(f"the chunk overlaps the one at byte {self._positions[next_index]}")

    def _read_loose(self, stored: bytes) -> Messages:
        if self._old is not None:
            return read_old(stored, self._old)[0]
        return read_content(stored, partial=True)[0]

    def _damaged(self, chunk: Chunk, reason: str) -> BagError:
        return BagError(self.path, f"{reason}; `pyros1 bag reindex` saves all that can be read", chunk.pos)

    def _set_index(self, connections: dict[int, Connection], chunks: list[Chunk]) -> None:
        self.connections, self.chunks = connections, chunks
        self._positions = sorted(chunk.pos for chunk in chunks)

    def _scan(self, progress: Callable[[int], object] | None) -> None:
        self.chunks, self.connections, self._positions = [], {}, []
        scanner = Scanner(self.file, progress)
        for found in scanner.chunks():
            if found.messages:
                self.chunks.append(found.chunk)
        self.connections = scanner.connections
        self.damages = scanner.damages
        self.scanned = True
        if self.file.version == 102:
            self._old = scanner.old


class _ChunkCache:
    """The contents of the chunks being read. If too many overlap in time, the least recently used are read again later.

    Args:
        reader: reads them.
        select: chooses and sorts the messages of a chunk.
    """

    def __init__(self, reader: BagReader, select: Callable[[Messages], Messages]) -> None:
        self._reader = reader
        self._select = select
        self._cache: dict[int, tuple[bytes, Messages]] = {}
        self._memory_size = 0

    def get(self, chunk: Chunk) -> tuple[bytes, Messages]:
        cached = self._cache.get(chunk.pos)
        if cached is not None:
            if self._memory_size > MAX_OPEN // 2:
                self._cache[chunk.pos] = self._cache.pop(chunk.pos)  # as the most recently used one
            return cached
        content, found = self._reader.content(chunk)
        cached = self._cache[chunk.pos] = content, self._select(found)
        self._memory_size += _memory_size(cached)
        while self._memory_size > MAX_OPEN and len(self._cache) > 1:
            self._memory_size -= _memory_size(self._cache.pop(next(iter(self._cache))))
        return cached

    def drop(self, chunk: Chunk) -> None:
        cached = self._cache.pop(chunk.pos, None)
        if cached is not None:
            self._memory_size -= _memory_size(cached)


def _memory_size(cached: tuple[bytes, Messages]) -> int:
    return len(cached[0]) + Messages.SIZE * len(cached[1])
