"""Writes bags with sorted indexes and unchanged connection headers; each chunk is written when it is full."""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import FileIO
from types import TracebackType
from typing import IO, Any

from pyros1.bag.errors import BagError
from pyros1.bag.format.compression import COMPRESSIONS, MAX_CHUNK_SIZE, Buffer, compress
from pyros1.bag.format.contents import Messages
from pyros1.bag.format.encryption import Cipher
from pyros1.bag.format.files import Chunk, Counts, file_label
from pyros1.bag.format.records import (
    BAG_HEADER_SIZE,
    MAGIC_20,
    MAX_TIME,
    NS_PER_S,
    OP_CHUNK,
    OP_CHUNK_INFO,
    OP_INDEX,
    U32,
    U64,
    Connection,
    make_bag_header,
    make_connection_record,
    make_record,
    message_record_prefix,
    pack_time,
)

CHUNK_THRESHOLD = 768 * 1024
"""Size in bytes, uncompressed, above which a chunk is closed."""

EMPTY_BAG_SIZE = len(MAGIC_20) + 8 + BAG_HEADER_SIZE
"""Size in bytes of a bag without messages."""

_TIME_AND_SIZE = struct.Struct("<III")
_INDEX_ENTRY = struct.Struct("<III")
_CONN_AND_COUNT = struct.Struct("<II")

_LARGE_MESSAGE_SIZE = 256 * 1024
"""Size in bytes from which a message ends its chunk, unless chunks are compressed."""

Entries = dict[int, bytes | bytearray]
"""Connection id -> data of its index record: each message's time and offset in the chunk's content.

The messages are sorted by time, since stock's readers use binary search.
"""


@dataclass(frozen=True)
class ExistingBag:
    """The content of a bag to which a writer appends.

    Attributes:
        connections: its connections by id.
        chunks: its chunks, in index order.
        end: offset in the file after the last chunk's index records.
    """

    connections: Mapping[int, Connection]
    chunks: Sequence[Chunk]
    end: int


class BagWriter:
    """Writes a bag.

    Until it is closed it has no index; reindexing can recover all chunks that were written. If a write fails, for
    example on a full disk, the incomplete record is removed, so that the bag can still be closed.

    Args:
        target: path of the file, which is replaced if it exists; or a binary file open for reading and writing, which
            stays open when the bag is closed.
        compression: ``none``, ``bz2`` or ``lz4``.
        chunk_threshold: uncompressed size in bytes above which a chunk is closed.
        cipher: encrypts the bag; None for an unencrypted bag.
        existing: the existing content of the file, which is kept; None for a new bag. See
            `pyros1.bag.format.appending`.

    Attributes:
        path: path of the file, or the name of an open file.
        connections: the connections, by id.
        messages: number of messages written, including those that were already in the file.

    Raises:
        OSError: the file cannot be created, or the disk is full; no new file is left behind.
        ValueError: the compression is unknown.
    """

    def __init__(
        self,
        target: str | os.PathLike[str] | IO[bytes],
        compression: str = "none",
        chunk_threshold: int = CHUNK_THRESHOLD,
        cipher: Cipher | None = None,
        existing: ExistingBag | None = None,
    ) -> None:
        if compression not in COMPRESSIONS:
            raise ValueError(f"unknown compression {compression!r}: use one of {', '.join(COMPRESSIONS)}")
        self.path = file_label(target)
        self.compression = compression
        self.chunk_threshold = chunk_threshold
        self.connections: dict[int, Connection] = {} if existing is None else dict(existing.connections)
        self._record_prefixes = {conn_id: message_record_prefix(conn_id) for conn_id in self.connections}
        self._next_id = max(self.connections, default=-1) + 1
        self._chunks: list[Chunk] = [] if existing is None else list(existing.chunks)
        self.messages = sum(sum(chunk.counts.values()) for chunk in self._chunks)
        self._content = bytearray()
        self._index: dict[int, list[tuple[int, int]]] = {}  # connection id -> time in ns, offset
        self._cipher = cipher
        self._closed = False
        self._size = 0
        self._owns_file = isinstance(target, (str, os.PathLike))
        file: Any = FileIO(self.path, "wb" if existing is None else "r+b") if self._owns_file else target
        self._file = file
        try:
            self._append(MAGIC_20 + self._bag_header())
            if existing is not None:  # from now on the bag counts as not closed, until its new index is written
                self._size = existing.end
            if existing is not None or not self._owns_file:
                self._file.truncate(self._size)
                self._file.seek(self._size)
        except BaseException as error:
            self.abort()
            if isinstance(error, OSError) and error.filename is None:
                error.filename = self.path
            if self._owns_file and existing is None and os.path.isfile(self.path):
                os.unlink(self.path)
            raise

    @property
    def size(self) -> int:
        """Number of bytes in the file and in the open chunk."""
        return self._size + len(self._content)

    @property
    def chunks(self) -> Sequence[Chunk]:
        """The chunks that were written, in file order."""
        return tuple(self._chunks)

    @property
    def cipher(self) -> Cipher | None:
        """The cipher that encrypts the bag; None for an unencrypted bag."""
        return self._cipher

    @property
    def pending(self) -> bool:
        """Whether the open chunk, which would be lost in a crash, contains any data."""
        return bool(self._content)

    def add_connection(self, topic: str, header: Mapping[str, bytes], conn: int | None = None) -> int:
        """Add a connection.

        Args:
            topic: name of its topic.
            header: all fields of the connection header; needs ``type``, ``md5sum`` and ``message_definition``. The
                topic is added if it is missing.
            conn: its id, which must be unique; None for the next free id.

        Returns:
            The id of the connection.
        """
        fields = {"topic": topic.encode("utf-8", "surrogateescape"), **header}
        return self.put_connection(topic, fields, conn, in_chunk=True)

    def put_connection(self, topic: str, header: Mapping[str, bytes], conn: int | None, *, in_chunk: bool) -> int:
        """Add a connection, with its header unchanged.

        Args:
            in_chunk: whether to write it into the open chunk as well; False if it is in a copied chunk.

        Returns:
            The id of the connection.
        """
        conn_id = self._next_id if conn is None else conn
        self._next_id = max(self._next_id, conn_id + 1)
        connection = Connection(conn_id, topic, header)
        self.connections[conn_id] = connection
        self._record_prefixes[conn_id] = message_record_prefix(conn_id)
        if in_chunk:
            self._content += make_connection_record(connection)
        return conn_id

    def write(self, conn: int, time: int, data: bytes | memoryview) -> None:
        """Write a message.

        Args:
            conn: id of its connection.
            time: receive time in nanoseconds.
            data: its bytes.

        Raises:
            BagError: the time cannot be stored in a bag.
            OSError: the file cannot be written.
            ValueError: the bag is closed.
        """
        if self._closed:
            raise ValueError("I/O operation on closed bag")
        if not 0 <= time <= MAX_TIME:
            raise BagError(self.path, f"the time {time / NS_PER_S:.3f} s cannot be stored: bags can store 0 to 2^32 s")
        if len(self._content) + len(data) > MAX_CHUNK_SIZE and self._content:
            self.flush()
        state_before = self._rollback_state()
        content, index = state_before[0], state_before[3]
        secs, nsecs = divmod(time, NS_PER_S)
        try:
            index.setdefault(conn, []).append((time, len(content)))
            content += self._record_prefixes[conn]
            content += _TIME_AND_SIZE.pack(secs, nsecs, len(data))
            self.messages += 1
            if len(content) + len(data) > self.chunk_threshold or (
                len(data) >= _LARGE_MESSAGE_SIZE and self.compression == "none"
            ):
                self._content = bytearray()
                self._write_chunk([content, data])
            else:
                content += data
        except OSError:
            raise
        except BaseException:
            self._roll_back(state_before, conn)
            raise

    def flush(self) -> None:
        """Write the open chunk to the file, so that its messages survive a crash of this process."""
        if not self._content:
            return
        state_before = self._rollback_state()
        try:
            content, self._content = self._content, bytearray()
            self._write_chunk([content])
        except OSError:
            raise
        except BaseException:
            self._roll_back(state_before)
            raise

    def _rollback_state(self) -> tuple[bytearray, int, int, dict[int, list[tuple[int, int]]], int, int]:
        """Return the state that `_roll_back` restores: the open chunk, its size, the file's size, the index, and the
        numbers of chunks and messages.
        """
        content = self._content
        return content, len(content), self._size, self._index, len(self._chunks), self.messages

    def _roll_back(self, state_before: tuple[Any, ...], conn: int | None = None) -> None:
        """Undo the writing of a message or chunk that was interrupted by an exception, such as KeyboardInterrupt."""
        content, content_size, file_size, index, chunk_count, message_count = state_before
        if len(self._chunks) > chunk_count:
            return  # the chunk has already been written
        self._truncate(file_size)
        positions = index.get(conn, ())
        if positions and positions[-1][1] == content_size:
            positions.pop()
        self._content, self._index = (
            content[:content_size],
            {conn_id: entries for conn_id, entries in index.items() if entries},
        )
        self.messages = message_count

    def _truncate(self, size: int) -> None:
        self._file.truncate(size)
        self._file.seek(size)
        self._size = size

    def _write_chunk(self, parts: Sequence[Buffer]) -> None:
        """Write a chunk with the given content, which is passed in parts and not copied; clear the index of the open
        chunk.
        """
        entries = self._pop_entries()
        size = sum(map(len, parts))
        stored = compress(self.compression, parts)
        if self._cipher is not None:
            stored = self._cipher.encrypt_parts(stored)
        self._write_stored_chunk(self.compression, size, stored, entries)

    def _pop_entries(self) -> Entries:
        index, self._index = self._index, {}
        pack = _INDEX_ENTRY.pack
        return {
            conn: b"".join(pack(*divmod(time, NS_PER_S), offset) for time, offset in sorted(positions))
            for conn, positions in index.items()
        }

    def copy_chunk(self, compression: str, size: int, stored: bytes, messages: Messages) -> None:
        """Write a complete chunk that was read from another bag.

        Args:
            compression: compression of its content.
            size: size of its content in bytes, uncompressed.
            stored: its stored bytes, encrypted with this bag's key if this bag is encrypted.
            messages: the positions of the messages in it.
        """
        self._write_stored_chunk(compression, size, [stored], _index_entries(messages))

    def _write_stored_chunk(self, compression: str, size: int, parts: Sequence[Buffer], entries: Entries) -> None:
        """Write a chunk whose stored bytes are passed in parts; these may be large and are not copied."""
        pos = self._size
        fields = {"op": bytes([OP_CHUNK]), "compression": compression.encode(), "size": U32.pack(size)}
        record = make_record(fields)[: -U32.size] + U32.pack(sum(map(len, parts)))
        indexes = b"".join(_index_record(conn, packed) for conn, packed in entries.items())
        try:
            for part in (record, *parts, indexes):
                self._append(part)
        except OSError:
            self.messages -= sum(map(entry_count, entries.values()))
            self._truncate(pos)
            raise
        counts = b"".join(_CONN_AND_COUNT.pack(conn, entry_count(packed)) for conn, packed in entries.items())
        edge_times = [
            _entry_time(packed, position)
            for packed in entries.values()
            for position in (0, len(packed) - _INDEX_ENTRY.size)
        ]
        self._chunks.append(Chunk(pos, min(edge_times, default=0), max(edge_times, default=0), Counts(counts)))

    def close(self) -> None:
        """Write the remaining data and the index, and close the file. A second call does nothing.

        Raises:
            OSError: the file cannot be written; it is closed anyway, and can be reindexed.
        """
        if self._closed:
            return
        try:
            try:
                self.flush()
            finally:
                self._write_end()
        finally:
            self.abort()

    def abort(self) -> None:
        """Close the file in its current state, without an index."""
        self._closed = True
        if self._owns_file:
            self._file.close()

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self, error_type: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _write_end(self) -> None:
        index_pos = self._size
        encrypt = None if self._cipher is None else self._cipher.encrypt
        parts = [make_connection_record(connection, encrypt) for connection in self.connections.values()]
        parts += [_chunk_info_record(chunk) for chunk in self._chunks]
        self._append(b"".join(parts))
        self._file.seek(len(MAGIC_20))
        self._write_fully(self._bag_header(index_pos))

    def _bag_header(self, index_pos: int = 0) -> bytes:
        fields = {} if self._cipher is None else self._cipher.fields
        return make_bag_header(index_pos, len(self.connections), len(self._chunks), fields)

    def _append(self, data: Buffer) -> None:
        if not self._owns_file:
            self._file.seek(self._size)  # readers of the same file object move its position
        self._write_fully(data)
        self._size += len(data)

    def _write_fully(self, data: Buffer) -> None:
        view = memoryview(data)
        while view:
            view = view[self._file.write(view) :]


def entry_count(entries: bytes | bytearray) -> int:
    """Return the number of messages in the data of an index record."""
    return len(entries) // _INDEX_ENTRY.size


def _entry_time(entries: bytes | bytearray, position: int) -> int:
    secs, nsecs, _ = _INDEX_ENTRY.unpack_from(entries, position)
    return int(secs) * NS_PER_S + int(nsecs)


def _index_entries(messages: Messages) -> Entries:
    """Return the index entries of a chunk's messages. There may be millions of them."""
    entries: dict[int, bytearray] = {}
    ordered = messages.sorted_by_time()
    pack = _INDEX_ENTRY.pack
    for conn, time, offset in zip(ordered.conns, ordered.times, ordered.offsets, strict=True):
        packed = entries.get(conn)
        if packed is None:
            packed = entries[conn] = bytearray()
        packed += pack(*divmod(time, NS_PER_S), offset)
    return dict(entries)


def _index_record(conn: int, entries: bytes | bytearray) -> bytes:
    fields = {
        "op": bytes([OP_INDEX]),
        "ver": U32.pack(1),
        "conn": U32.pack(conn),
        "count": U32.pack(entry_count(entries)),
    }
    return make_record(fields, entries)


def _chunk_info_record(chunk: Chunk) -> bytes:
    counts = chunk.counts.items()
    fields = {
        "op": bytes([OP_CHUNK_INFO]),
        "ver": U32.pack(1),
        "chunk_pos": U64.pack(chunk.pos),
        "start_time": pack_time(chunk.start),
        "end_time": pack_time(chunk.end),
        "count": U32.pack(len(counts)),
    }
    return make_record(fields, b"".join(_CONN_AND_COUNT.pack(*item) for item in counts))
