"""Reads a bag's messages in time order. Only the index of the chunks and the chunks being read are in memory."""

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
from pyros1.bag.format.index import INDEX_ENTRY, check_version_1_2, entry_ranges, read_index
from pyros1.bag.format.records import (
    MAX_TIME,
    NS_PER_S,
    Connection,
    LimitError,
    RecordError,
)
from pyros1.bag.format.scanner import Damage, Scanner
from pyros1.bag.format.version_1_2 import OldConnections, read_old_messages

if TYPE_CHECKING:
    from pyros1.bag.format.writer import BagWriter

MAX_OPEN_BYTES = 256 << 20
"""Maximum total size in bytes of the chunks in memory, for chunks that overlap in time."""


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


class LocatedMessage(NamedTuple):
    """A stored message and its location.

    Attributes:
        connection, time, data: as in `RawMessage`.
        location: offset of its chunk in the file, and of its record in the chunk's content.
    """

    connection: Connection
    time: int
    data: bytes
    location: tuple[int, int]


class Entry(NamedTuple):
    """A message's entry in the index.

    Attributes:
        conn: id of its connection.
        time: receive time in nanoseconds.
        location: as in `LocatedMessage`.
    """

    conn: int
    time: int
    location: tuple[int, int]


class BagReader:
    """A bag open for reading.

    Args:
        source: path of the file, or an open binary file, which stays open when the reader is closed.
        unindexed: whether to also read bags without a valid index. They are scanned first, as bags of version 1.2
            always are.
        progress: called with the offset in bytes while the file is scanned.
        chunk_limit: maximum size in bytes of a chunk's content. None means the value of the environment variable
            ``PYROS1_BAG_CHUNK_LIMIT``, in MiB, or 256 MiB if it is not set. `pyros1.bag.limits` lists the memory
        needed.
        unfinished_writer: the bag's writer, if it is not closed yet; it provides the index, which is not in the file.

    Attributes:
        connections: the connections, by id.
        chunks: the chunks, in index order.
        damaged_places: places that could not be read, if the file was scanned.
        was_scanned: whether the file was scanned.

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
        unfinished_writer: BagWriter | None = None,
    ) -> None:
        self.file = BagFile(source, chunk_limit)
        self.connections: dict[int, Connection] = {}
        self.chunks: list[Chunk] = []
        self.damaged_places: list[Damage] = []
        self.was_scanned = False
        self._old_connections: OldConnections | None = None
        self._positions: list[int] = []  # offsets of the chunks in the index, sorted
        try:
            if unfinished_writer is not None:
                self.file.cipher = unfinished_writer.cipher
                self._set_index(dict(unfinished_writer.connections), list(unfinished_writer.chunks))
                return
            self.file.unlock()
            if self.file.version == 102:
                self._scan(progress)
                if not unindexed:
                    check_version_1_2(self.file, self.damaged_places)
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
        return sum(message_count for conn, message_count in counts if connections is None or conn in connections)

    def connection_ids(self, topics: Collection[str]) -> set[int]:
        """Return the ids of the connections on the topics; a leading ``/`` is ignored unless the bag has both names."""
        recorded_names = {connection.topic for connection in self.connections.values()}
        exact_names = recorded_names.intersection(topics)
        other_names = {topic.lstrip("/") for topic in topics if topic not in exact_names}
        return {
            conn_id
            for conn_id, connection in self.connections.items()
            if connection.topic in exact_names or connection.topic.lstrip("/") in other_names
        }

    def messages(
        self,
        connections: Collection[int] | None = None,
        start: int | None = None,
        end: int | None = None,
        *,
        ranks: Mapping[int, int] | None = None,
    ) -> Iterator[RawMessage]:
        """Yield messages in time order; messages with the same time are in file order.

        Args:
            connections: ids of the wanted connections; None means all.
            start: earliest time in nanoseconds; None for no limit.
            end: latest time in nanoseconds; None for no limit.
            ranks: connection id -> rank; if given, messages with the same time are sorted by rank, and those with the
                same rank are in file order.

        Raises:
            BagError: a chunk cannot be read.
        """
        return self._iter_merged(RawMessage, connections, start, end, ranks)

    def located_messages(
        self,
        connections: Collection[int] | None = None,
        start: int | None = None,
        end: int | None = None,
        *,
        ranks: Mapping[int, int] | None = None,
    ) -> Iterator[LocatedMessage]:
        """Yield messages with their locations; arguments, order and errors as for :meth:`messages`."""
        return self._iter_merged(LocatedMessage, connections, start, end, ranks)

    def _iter_merged(
        self,
        message_type: type[Any],
        connections: Collection[int] | None,
        start: int | None,
        end: int | None,
        ranks: Mapping[int, int] | None,
    ) -> Iterator[Any]:
        first, last = 0 if start is None else start, MAX_TIME if end is None else end
        chunks = [chunk for chunk in self.chunks if chunk.end >= first and chunk.start <= last]
        if connections is not None:
            chunks = [chunk for chunk in chunks if not chunk.counts.keys().isdisjoint(connections)]
        all_conns = self.connections
        pending = deque(sorted(chunks, key=lambda chunk: (chunk.start, chunk.pos)))

        wanted_ids = all_conns.keys() if connections is None else all_conns.keys() & set(connections)

        def select(messages: Messages) -> Messages:
            if start is not None or end is not None:
                messages = messages.where(lambda conn, time: conn in wanted_ids and first <= time <= last)
            elif not wanted_ids >= set(messages.conns):
                messages = messages.where(lambda conn, time: conn in wanted_ids)
            return messages.sorted_by_time(ranks)

        def sort_key(selected: Messages, index: int) -> tuple[int, int]:
            return selected.times[index], 0 if ranks is None else ranks[selected.conns[index]]

        is_located = message_type is LocatedMessage
        heap: list[tuple[tuple[int, int], int, int, Chunk]] = []  # sort key, offset, index of next message, chunk
        cache = _ChunkCache(self, select)
        while pending or heap:
            while pending and (not heap or pending[0].start <= heap[0][0][0]):
                chunk = pending.popleft()
                selected = cache.get(chunk)[1]
                if selected:
                    heapq.heappush(heap, (sort_key(selected, 0), chunk.pos, 0, chunk))
                else:
                    cache.drop(chunk)
            if not heap:
                continue
            _, pos, index, chunk = heapq.heappop(heap)
            content, selected = cache.get(chunk)
            next_time = min(heap[0][0][0] if heap else MAX_TIME + 1, pending[0].start if pending else MAX_TIME + 1)
            next_index = bisect_left(selected.times, next_time, index + 1)
            last_index = next_index - 1
            if last_index > index and is_located:
                for positions in selected.iter_range(index, last_index):
                    conn, time, begin, stop = positions[:4]
                    yield LocatedMessage(all_conns[conn], time, content[begin:stop], (pos, selected.offsets[index]))
                    index += 1
            elif last_index > index:
                for conn, time, begin, stop in selected.iter_range(index, last_index):
                    yield RawMessage(all_conns[conn], time, content[begin:stop])
            ((conn, time, begin, stop),) = selected.iter_range(last_index, next_index)
            location = ((pos, selected.offsets[last_index]),) if is_located else ()
            message = message_type(all_conns[conn], time, content[begin:stop], *location)
            if next_index < len(selected):
                heapq.heappush(heap, (sort_key(selected, next_index), pos, next_index, chunk))
            else:
                cache.drop(chunk)
            # A large message has a chunk of its own; neither may stay in memory longer than needed.
            del content, selected
            yield message
            del message

    def at(self, location: tuple[int, int]) -> RawMessage:
        """Return the message at a location. Its whole chunk is read.

        Raises:
            BagError: there is no message at the location, or its chunk cannot be read.
        """
        pos, offset = location
        for chunk in self.chunks:
            if chunk.pos == pos:
                content, messages = self.content(chunk)
                index = bisect_left(messages.offsets, offset)
                if index < len(messages) and messages.offsets[index] == offset:
                    return RawMessage(
                        self.connections[messages.conns[index]],
                        messages.times[index],
                        content[messages.starts[index] : messages.ends[index]],
                    )
        raise BagError(self.path, f"there is no message at {offset} in a chunk at {pos}")

    def entries(self) -> Iterator[Entry]:
        """Yield an index entry for each message, in no particular order; raises the same errors as :meth:`times`."""
        for chunk in self.chunks:
            ranges = None if self.was_scanned else entry_ranges(self.file, chunk, self.header(chunk))
            if ranges is None:
                messages = self.content(chunk)[1]
                for conn, time, offset in zip(messages.conns, messages.times, messages.offsets, strict=True):
                    yield Entry(conn, time, (chunk.pos, offset))
                continue
            for conn, start, size in ranges:
                for secs, nsecs, offset in INDEX_ENTRY.iter_unpack(self.file.read(start, size)):
                    yield Entry(conn, secs * NS_PER_S + nsecs, (chunk.pos, offset))

    def times(self) -> Iterator[tuple[int, int]]:
        """Return (connection id, time in nanoseconds) of every message, in no particular order.

        Chunks with an index are not decompressed: only the index is read.

        Raises:
            BagError: a chunk cannot be read.
        """
        return ((entry.conn, entry.time) for entry in self.entries())

    def headers(self) -> Iterator[ChunkHeader]:
        """Yield the headers of all chunks. This is fast even for many chunks, since the system prefetches the headers.

        Raises:
            BagError: a header cannot be read.
        """
        self.file.prefetch(chunk.pos for chunk in self.chunks)
        return map(self.header, self.chunks)

    def content_size(self) -> int:
        """Return the total uncompressed size of the bag's chunks in bytes."""
        return sum(header.size for header in self.headers())

    def header(self, chunk: Chunk) -> ChunkHeader:
        """Return a chunk's header, or an equivalent one for messages outside of chunks.

        Raises:
            BagError: the chunk cannot be read.
        """
        if chunk.loose_size:
            return ChunkHeader("none", chunk.loose_size, chunk.pos, chunk.loose_size)
        try:
            return self.file.chunk_header(chunk.pos)
        except RecordError as error:
            raise self._damage_error(chunk, str(error)) from None

    def content(self, chunk: Chunk) -> tuple[bytes, Messages]:
        """Return a chunk's content, and the positions of the messages in it, in file order.

        Raises:
            BagError: the chunk cannot be read.
        """
        header = self.header(chunk)
        file = self.file
        try:
            check_size(header.size, file.limit)
            self._check_overlap(chunk, header)
            is_unfinished = not chunk.is_complete and not header.stored_size
            stored = file.read(header.data_offset, file.limit if is_unfinished else header.trusted_size(file.limit))
            if chunk.loose_size:
                return stored, self._read_partial(stored)
            if chunk.is_complete and len(stored) < header.stored_size:
                is_cut_off = header.data_offset + header.stored_size > file.size
                raise RecordError(
                    "the chunk runs past the end of the file"
                    if is_cut_off
                    else "the chunk's lengths contradict each other"
                )
            partial = not chunk.is_complete
            stored = file.decrypt(stored, partial=partial)
            content = decompress(header.compression, stored, header.size or file.limit, file.limit, partial=partial)
            messages, _ = read_content(content, partial=partial)
        except RecordError as error:
            if isinstance(error, LimitError):
                raise BagError(self.path, str(error), chunk.pos) from None
            raise self._damage_error(chunk, str(error)) from None
        return content, messages

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def __enter__(self) -> BagReader:
        return self

    def __exit__(
        self, error_type: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _check_overlap(self, chunk: Chunk, header: ChunkHeader) -> None:
        """Raise RecordError if a chunk overlaps the next one: many such chunks could each contain most of the file."""
        next_index = bisect_right(self._positions, chunk.pos)
        if next_index < len(self._positions) and header.data_offset + header.stored_size > self._positions[next_index]:
            raise RecordError(f"the chunk overlaps the one at byte {self._positions[next_index]}")

    def _read_partial(self, stored: bytes) -> Messages:
        if self._old_connections is not None:
            return read_old_messages(stored, self._old_connections)[0]
        return read_content(stored, partial=True)[0]

    def _damage_error(self, chunk: Chunk, reason: str) -> BagError:
        return BagError(self.path, f"{reason}; `pyros1 bag reindex` recovers everything that can be read", chunk.pos)

    def _set_index(self, connections: dict[int, Connection], chunks: list[Chunk]) -> None:
        self.connections, self.chunks = connections, chunks
        self._positions = sorted(chunk.pos for chunk in chunks)

    def _scan(self, progress: Callable[[int], object] | None) -> None:
        self.chunks, self.connections, self._positions = [], {}, []
        scanner = Scanner(self.file, progress)
        for scanned_chunk in scanner.chunks():
            if scanned_chunk.messages:
                self.chunks.append(scanned_chunk.chunk)
        self.connections = scanner.connections
        self.damaged_places = scanner.damaged_places
        self.was_scanned = True
        if self.file.version == 102:
            self._old_connections = scanner.old_connections


class _ChunkCache:
    """The contents of the chunks being read. If too many chunks overlap in time, the least recently used contents are
    dropped and read again later.

    Args:
        reader: reads the chunks.
        select: selects and sorts the messages of a chunk.
    """

    def __init__(self, reader: BagReader, select: Callable[[Messages], Messages]) -> None:
        self._reader = reader
        self._select = select
        self._cache: dict[int, tuple[bytes, Messages]] = {}
        self._memory_size = 0

    def get(self, chunk: Chunk) -> tuple[bytes, Messages]:
        cached = self._cache.get(chunk.pos)
        if cached is not None:
            if self._memory_size > MAX_OPEN_BYTES // 2:
                self._cache[chunk.pos] = self._cache.pop(chunk.pos)  # now the most recently used chunk
            return cached
        content, messages = self._reader.content(chunk)
        cached = self._cache[chunk.pos] = content, self._select(messages)
        self._memory_size += _memory_size(cached)
        while self._memory_size > MAX_OPEN_BYTES and len(self._cache) > 1:
            self._memory_size -= _memory_size(self._cache.pop(next(iter(self._cache))))
        return cached

    def drop(self, chunk: Chunk) -> None:
        self._memory_size -= _memory_size(self._cache.pop(chunk.pos))


def _memory_size(cached: tuple[bytes, Messages]) -> int:
    return len(cached[0]) + Messages.BYTES_PER_MESSAGE * len(cached[1])
