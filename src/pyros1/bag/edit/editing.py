"""New bags from old ones: chosen, merged, renamed, moved in time, compressed. Connection headers are kept.

All of it is one pass over messages in the order of time, into a `Copy`. What commands make of an encrypted bag is
encrypted with the same key.
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
class Choice:
    """Which messages are wanted; as it stands, all.

    Attributes:
        topics: names or patterns with ``*``; empty means all.
        start: earliest time in nanoseconds, None for no limit.
        end: latest time.
        drop: connections that are not wanted: their ids, or names of their publishers.
    """

    topics: Sequence[str] = ()
    start: int | None = None
    end: int | None = None
    drop: Collection[str] = field(default_factory=frozenset)

    def connections(self, bag: BagReader) -> set[int]:
        """Return the ids of the connections wanted."""
        return {number for number, connection in bag.connections.items() if self._wants(connection)}

    def messages(self, bag: BagReader) -> Iterator[RawMessage]:
        """Yield a bag's messages that are wanted, by time."""
        return bag.messages(self.connections(bag), self.start, self.end)

    def _wants(self, connection: Connection) -> bool:
        if self.drop and not {str(connection.id), connection.callerid}.isdisjoint(self.drop):
            return False
        name = connection.topic.lstrip("/")
        return not self.topics or any(fnmatch.fnmatchcase(name, topic.lstrip("/")) for topic in self.topics)


def merged(bags: Sequence[BagReader], choice: Choice | None = None) -> Iterator[RawMessage]:
    """Yield the messages of several bags by time; of the same time, in the order of the bags.

    Raises:
        BagError: a bag cannot be read.
    """
    streams = [(choice or Choice()).messages(bag) for bag in bags]
    return streams[0] if len(streams) == 1 else heapq.merge(*streams, key=lambda message: message.time)


class Copy:
    """Writes messages of other bags into a new one.

    Connections with the same topic and header become one.

    Args:
        writer: the new bag.
        rename: returns a topic's new name.
    """

    def __init__(self, writer: BagWriter, rename: Callable[[str], str] | None = None) -> None:
        self._writer = writer
        self._rename = rename
        self._numbers: dict[int, int] = {}
        self._sources: list[Connection] = []  # keeps them alive, so that their ids stay theirs
        self._known: dict[tuple[object, ...], int] = {}

    def write(self, message: RawMessage, time: int | None = None) -> None:
        """Write a message.

        Args:
            time: in nanoseconds, if not its own.

        Raises:
            BagError: the time does not fit.
            OSError: the disk is full, ...
        """
        number = self._numbers.get(id(message.connection))
        if number is None:
            number = self._add(message.connection)
        self._writer.write(number, message.time if time is None else time, message.data)

    def _add(self, connection: Connection) -> int:
        topic = connection.topic if self._rename is None else self._rename(connection.topic)
        header = dict(connection.header)
        if topic != connection.topic:
            header["topic"] = topic.encode("utf-8", "surrogateescape")
        key = (topic, *sorted(header.items()))
        number = self._known.get(key)
        if number is None:
            number = self._known[key] = self._writer.put_connection(topic, header, None, inside=True)
        self._sources.append(connection)
        self._numbers[id(connection)] = number
        return number


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
    """Write messages into a new bag.

    Args:
        messages: of one bag or several.
        target: the new file; replaced if it exists.
        compression: ``none``, ``bz2`` or ``lz4``.
        chunk_threshold: bytes, uncompressed, beyond which a chunk is closed.
        cipher: encrypts the new bag.
        rename: returns a topic's new name.
        retime: returns a message's new time in nanoseconds.
        progress: called with the number of bytes written so far, before compression.

    Returns:
        How many messages were written.

    Raises:
        BagError: a bag cannot be read, or a time does not fit.
        OSError: the disk is full, ...
    """
    with BagWriter(target, compression, chunk_threshold, cipher) as writer:
        out = Copy(writer, rename)
        done = 0
        for message in messages:
            out.write(message, None if retime is None else retime(message))
            done += len(message.data) + RECORD_OVERHEAD
            if progress is not None:
                progress(done)
            del message  # it may be large, and is not to be in memory while the next one is read
        return writer.messages


def split(
    messages: Iterator[RawMessage],
    name: Callable[[int], str],
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
        messages: by time.
        name: returns the file of a part, given its number from 0; replaced if it exists, once the part is whole.
        size: begin another part when one has so many bytes.
        duration: begin another part after so many nanoseconds.
        count: begin another part after so many messages.
        cipher: encrypts the new bags.
        repeat_latched: begin every part with the last message of each latched connection, at the part's first time.
        progress: called with the number of bytes that are done, before compression.

    Returns:
        The files.

    Raises:
        BagError: a bag cannot be read.
        OSError: the disk is full, ...
    """
    paths: list[str] = []
    latched: dict[int, RawMessage] = {}
    done = 0
    message = next(messages, None)
    while message is not None:
        paths.append(name(len(paths)))
        begin = message.time
        with _part(paths[-1], compression, cipher) as writer:
            out = Copy(writer)
            for old in latched.values():
                out.write(old, begin)
            while message is not None:
                out.write(message)
                if repeat_latched and message.connection.latching:
                    latched[id(message.connection)] = message
                done += len(message.data) + RECORD_OVERHEAD
                if progress is not None:
                    progress(done)
                message = next(messages, None)
                if message is not None and (
                    (size is not None and writer.size >= size)
                    or (duration is not None and message.time - begin >= duration)
                    or (count is not None and writer.messages >= count)
                ):
                    break
    return paths


@contextmanager
def _part(path: str, compression: str, cipher: Cipher | None) -> Iterator[BagWriter]:
    """A new bag that gets its name only when it is whole, and vanishes if it will not be."""
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


def shifted(offset: int, rate: float = 1.0, origin: int = 0) -> Callable[[RawMessage], int]:
    """Return a `retime` that moves times.

    Args:
        offset: nanoseconds to add.
        rate: 2.0 brings messages twice as close together.
        origin: the time in nanoseconds that only `offset` moves.
    """

    def move(message: RawMessage) -> int:
        since = message.time - origin
        return origin + offset + (since if rate == 1.0 else round(since / rate))

    return move
