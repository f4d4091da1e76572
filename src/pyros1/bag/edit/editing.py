"""Writes new bags from existing ones: selects messages, merges bags, renames topics, shifts times, and compresses.

Connection headers are kept. Each operation is one pass over the messages in time order, into a `CopyWriter`.
The commands that call this module encrypt the new bag with the key of the old one.
"""

from __future__ import annotations

import fnmatch
import heapq
import os
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from pyros1.bag.format.encryption import Cipher
from pyros1.bag.format.reader import BagReader, RawMessage
from pyros1.bag.format.records import RECORD_OVERHEAD, Connection
from pyros1.bag.format.writer import CHUNK_THRESHOLD, BagWriter


@dataclass(frozen=True)
class MessageSelection:
    """A selection of messages; by default all.

    Attributes:
        topics: topic names, or patterns with ``*``; empty means all.
        start: earliest time in nanoseconds; None for no limit.
        end: latest time in nanoseconds; None for no limit.
        drop: connections to leave out, by id or by the publisher's name.
    """

    topics: Sequence[str] = ()
    start: int | None = None
    end: int | None = None
    drop: Collection[str] = field(default_factory=frozenset)

    def connections(self, bag: BagReader) -> set[int]:
        """Return the ids of the selected connections."""
        return {conn_id for conn_id, connection in bag.connections.items() if self._selects(connection)}

    def messages(self, bag: BagReader) -> Iterator[RawMessage]:
        """Yield the selected messages of a bag, in time order."""
        return bag.messages(self.connections(bag), self.start, self.end)

    def _selects(self, connection: Connection) -> bool:
        if self.drop and not {str(connection.id), connection.callerid}.isdisjoint(self.drop):
            return False
        name = connection.topic.lstrip("/")
        return not self.topics or any(fnmatch.fnmatchcase(name, topic.lstrip("/")) for topic in self.topics)


def merge(bags: Sequence[BagReader], selection: MessageSelection | None = None) -> Iterator[RawMessage]:
    """Yield the messages of several bags in time order; messages with the same time are in the order of the bags.

    Raises:
        BagError: a bag cannot be read.
    """
    streams = [(selection or MessageSelection()).messages(bag) for bag in bags]
    return streams[0] if len(streams) == 1 else heapq.merge(*streams, key=lambda message: message.time)


class CopyWriter:
    """Writes messages from other bags into a new bag.

    Connections with the same topic and header are merged into one.

    Args:
        writer: the new bag.
        rename: returns a topic's new name.
    """

    def __init__(self, writer: BagWriter, rename: Callable[[str], str] | None = None) -> None:
        self._writer = writer
        self._rename = rename
        self._conn_id_by_source: dict[int, int] = {}
        self._sources: list[Connection] = []  # keeps the connections alive, so that their id() values are not reused
        self._conn_id_by_header: dict[tuple[object, ...], int] = {}

    def write(self, message: RawMessage, time: int | None = None) -> None:
        """Write a message.

        Args:
            message: the message, with its connection in the other bag.
            time: time in nanoseconds; None for the message's own time.

        Raises:
            BagError: the time is out of the range that bags can store.
            OSError: the file cannot be written, for example because the disk is full.
        """
        conn_id = self._conn_id_by_source.get(id(message.connection))
        if conn_id is None:
            conn_id = self._add_connection(message.connection)
        self._writer.write(conn_id, message.time if time is None else time, message.data)

    def _add_connection(self, connection: Connection) -> int:
        topic = connection.topic if self._rename is None else self._rename(connection.topic)
        header = dict(connection.header)
        if topic != connection.topic:
            header["topic"] = topic.encode("utf-8", "surrogateescape")
        key = (topic, *sorted(header.items()))
        conn_id = self._conn_id_by_header.get(key)
        if conn_id is None:
            conn_id = self._conn_id_by_header[key] = self._writer.put_connection(topic, header, None, in_chunk=True)
        self._sources.append(connection)
        self._conn_id_by_source[id(connection)] = conn_id
        return conn_id


def copy(
    messages: Iterator[RawMessage],
    target: str | os.PathLike[str],
    *,
    compression: str = "none",
    chunk_threshold: int = CHUNK_THRESHOLD,
    cipher: Cipher | None = None,
    rename: Callable[[str], str] | None = None,
    retime: Callable[[RawMessage], int] | None = None,
    progress: Callable[[int], object] | None = None,
) -> int:
    """Write messages into a new bag, in the given order.

    Args:
        messages: messages from one bag or several.
        target: the new file; replaced if it exists.
        compression: ``none``, ``bz2`` or ``lz4``.
        chunk_threshold: size in bytes, uncompressed, above which a chunk is closed.
        cipher: encrypts the new bag; None for an unencrypted bag.
        rename: returns a topic's new name.
        retime: returns a message's new time in nanoseconds.
        progress: called with the number of bytes written so far, before compression.

    Returns:
        The number of messages that were written.

    Raises:
        BagError: a bag cannot be read, or a time is out of the range that bags can store.
        OSError: the file cannot be written, for example because the disk is full.
    """
    with BagWriter(target, compression, chunk_threshold, cipher) as writer:
        copier = CopyWriter(writer, rename)
        bytes_done = 0
        for message in messages:
            copier.write(message, None if retime is None else retime(message))
            bytes_done += len(message.data) + RECORD_OVERHEAD
            if progress is not None:
                progress(bytes_done)
            del message  # it may be large, and must not stay in memory while the next message is read
        return writer.messages


def split(
    messages: Iterator[RawMessage],
    part_path: Callable[[int], str],
    *,
    size: int | None = None,
    duration: int | None = None,
    count: int | None = None,
    compression: str = "none",
    cipher: Cipher | None = None,
    repeat_latched: bool = False,
    progress: Callable[[int], object] | None = None,
) -> list[str]:
    """Write messages into several bags, one after the other.

    Args:
        messages: messages in time order.
        part_path: returns the path of a part, given its number, from 0; an existing file is replaced as soon as the
            part is complete.
        size: number of bytes after which a new part begins.
        duration: number of nanoseconds after which a new part begins.
        count: number of messages after which a new part begins.
        compression: ``none``, ``bz2`` or ``lz4``.
        cipher: encrypts the new bags; None for unencrypted bags.
        repeat_latched: whether each part begins with the last message of each latched connection; these get the time of
            its first message.
        progress: called with the number of bytes processed so far, before compression.

    Returns:
        The paths of the parts.

    Raises:
        BagError: a bag cannot be read.
        OSError: the file cannot be written, for example because the disk is full.
    """
    paths: list[str] = []
    latched: dict[int, RawMessage] = {}
    bytes_done = 0
    message = next(messages, None)
    while message is not None:
        paths.append(part_path(len(paths)))
        begin_time = message.time
        with _open_part(paths[-1], compression, cipher) as writer:
            copier = CopyWriter(writer)
            for latched_message in latched.values():
                copier.write(latched_message, begin_time)
            while message is not None:
                copier.write(message)
                if repeat_latched and message.connection.latching:
                    latched[id(message.connection)] = message
                bytes_done += len(message.data) + RECORD_OVERHEAD
                if progress is not None:
                    progress(bytes_done)
                message = next(messages, None)
                if message is not None and (
                    (size is not None and writer.size >= size)
                    or (duration is not None and message.time - begin_time >= duration)
                    or (count is not None and writer.messages >= count)
                ):
                    break
    return paths


@contextmanager
def _open_part(path: str, compression: str, cipher: Cipher | None) -> Iterator[BagWriter]:
    """Yield the writer of a new bag, which gets its final name when it is complete and is removed after an error."""
    writer = BagWriter(f"{path}.tmp", compression, cipher=cipher)
    try:
        yield writer
        writer.close()
        os.replace(writer.path, path)
    except BaseException as error:
        writer.abort()
        os.unlink(writer.path)
        if isinstance(error, OSError) and error.filename in (None, writer.path):
            error.filename = path
        raise


def time_shifter(offset: int, rate: float = 1.0, origin: int = 0) -> Callable[[RawMessage], int]:
    """Return a function that shifts message times, for the `retime` argument of `copy`.

    Args:
        offset: number of nanoseconds to add.
        rate: speed factor; 2.0 halves the time between messages.
        origin: the time in nanoseconds that `rate` leaves unchanged.
    """

    def shift(message: RawMessage) -> int:
        elapsed = message.time - origin
        return origin + offset + (elapsed if rate == 1.0 else round(elapsed / rate))

    return shift
