"""Repairs bags that were not closed, or are cut off, damaged or of version 1.2; no complete message is lost."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

from pyros1.bag.errors import BagError
from pyros1.bag.format.contents import Messages
from pyros1.bag.format.files import BagFile
from pyros1.bag.format.records import MAX_CONNECTIONS, MAX_TIME, Connection, RecordError
from pyros1.bag.format.scanner import Damage, ScannedChunk, Scanner
from pyros1.bag.format.writer import BagWriter


@dataclass(frozen=True)
class ReindexResult:
    """Result of reindexing.

    Attributes:
        messages: number of messages in the new bag.
        lost: number of complete messages that could not be copied, because they have no connection or an invalid time.
        damaged_places: the places in the old bag that could not be read.
    """

    messages: int
    lost: int
    damaged_places: list[Damage]


def reindex(
    source: str | os.PathLike[str], target: str | os.PathLike[str], progress: Callable[[int], object] | None = None
) -> ReindexResult:
    """Write all complete messages of a bag into a new bag.

    Complete chunks are copied unchanged, compressed or not, encrypted or not.

    Args:
        source: path of the damaged bag.
        target: the new file; replaced if it exists.
        progress: called with the current offset in the source, in bytes.

    Raises:
        NotABagError: the source is not a bag.
        EncryptedError: the source is encrypted, and its key is not available.
        BagError: source and target are the same file.
        OSError: a file cannot be read or written.
    """
    file = BagFile(source)
    try:
        if os.path.exists(target) and os.path.samefile(source, target):
            raise BagError(file.path, "a bag cannot be reindexed into itself: give another target file")
        scanner = Scanner(file, progress)  # also decrypts the key of an encrypted bag, and sets file.cipher
        for connection in _end_connections(file):
            scanner.connections[connection.id] = connection
        with BagWriter(target, cipher=file.cipher) as writer:
            rebuilder = _BagRebuilder(file, scanner, writer)
            for scanned_chunk in scanner.chunks():
                rebuilder.add_chunk(scanned_chunk)
                del scanned_chunk  # so that only one chunk is in memory
        return ReindexResult(rebuilder.messages, rebuilder.lost, scanner.damaged_places)
    finally:
        file.close()


def _end_connections(file: BagFile) -> list[Connection]:
    """Return the connections in the end section, up to the first damaged one: old recorders did not write all of them
    into chunks.
    """
    connections: list[Connection] = []
    position = file.index_pos
    while 0 < position < file.size and len(connections) < MAX_CONNECTIONS:
        try:
            connection, position = file.connection(position)
        except RecordError:
            break
        connections.append(connection)
    return connections


class _BagRebuilder:
    """Writes the chunks that the scanner finds into the new bag, with the same connection ids."""

    def __init__(self, file: BagFile, scanner: Scanner, writer: BagWriter) -> None:
        self._file = file
        self._scanner = scanner
        self._writer = writer
        self.messages = 0
        self.lost = 0

    def add_chunk(self, scanned_chunk: ScannedChunk) -> None:
        connections = self._scanner.connections
        copyable = scanned_chunk.messages.where(lambda conn, time: conn in connections and time <= MAX_TIME)
        self.messages += len(copyable)
        self.lost += len(scanned_chunk.messages) - len(copyable)
        if scanned_chunk.header is not None and scanned_chunk.chunk.is_complete:
            self._copy_chunk(scanned_chunk, copyable)
        else:
            for message in copyable:
                self._add_connection(message.conn, in_chunk=True)
                self._writer.write(message.conn, message.time, scanned_chunk.content[message.start : message.end])
            self._writer.flush()

    def _copy_chunk(self, scanned_chunk: ScannedChunk, copyable: Messages) -> None:
        header = scanned_chunk.header
        assert header is not None
        for conn in dict.fromkeys(copyable.conns):
            self._add_connection(conn, in_chunk=False)
        stored = self._file.read(header.data_offset, header.stored_size)
        self._writer.copy_chunk(header.compression, header.size, stored, copyable)

    def _add_connection(self, conn: int, *, in_chunk: bool) -> None:
        if conn not in self._writer.connections:
            connection = self._scanner.connections[conn]
            self._writer.put_connection(connection.topic, connection.header, conn, in_chunk=in_chunk)
