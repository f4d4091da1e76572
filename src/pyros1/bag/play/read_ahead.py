"""Merges the messages of several bags by time, and reads them ahead in a separate thread."""

from __future__ import annotations

import heapq
import threading
from collections import deque
from collections.abc import Collection, Iterator, Sequence
from itertools import repeat
from typing import NamedTuple

from pyros1.bag.format.reader import BagReader, RawMessage
from pyros1.bag.format.records import Connection
from pyros1.bag.play.static import is_static_transforms

MAX_AHEAD_BYTES = 32 << 20
"""Maximum number of bytes read ahead, not counting the last batch."""
_MAX_BATCH_BYTES = 1 << 20
_MAX_BATCH_MESSAGES = 500
_MESSAGE_OVERHEAD = 1500
"""Bytes counted per message in addition to its data. Deliberately higher than the real overhead, so that the limit in
bytes also limits the number of messages: each of them adds garbage collection time.
"""
_MAX_STATIC_CHUNKS = 20
"""Number of chunks at the beginning of a bag that are read for static transforms."""


class PlayItem(NamedTuple):
    """A message to play.

    Attributes:
        bag_index: index of its bag.
        message: the message with its connection and time.
    """

    bag_index: int
    message: RawMessage


class BagSet:
    """A set of open bags. A context manager that closes the bags on exit.

    Args:
        sources: paths of the files, or readers, which stay open when this object is closed.
        topics: the topics to play; None for all.

    Raises:
        BagError: one of the files is not a bag, or has no index.
        OSError: one of the files cannot be read.
    """

    def __init__(self, sources: Sequence[str | BagReader], topics: Collection[str] | None = None) -> None:
        self.readers: list[BagReader] = []
        self._opened: list[BagReader] = []
        self._selected_ids: list[set[int] | None] = []
        try:
            for source in sources:
                if isinstance(source, str):
                    self._opened.append(BagReader(source))
                self.readers.append(self._opened[-1] if isinstance(source, str) else source)
        except BaseException:
            self.close()
            raise
        for reader in self.readers:
            self._selected_ids.append(None if topics is None else reader.connection_ids(topics))

    @property
    def start(self) -> int:
        """Earliest time, in nanoseconds, of all bags; 0 without messages."""
        return min((reader.start for reader in self.readers if reader.start), default=0)

    @property
    def end(self) -> int:
        """Latest time, in nanoseconds, of all bags; 0 without messages."""
        return max((reader.end for reader in self.readers), default=0)

    def connections(self) -> Iterator[tuple[int, Connection]]:
        """Yield the connections to play, each with the index of its bag."""
        for bag_index, (reader, selected_ids) in enumerate(zip(self.readers, self._selected_ids, strict=True)):
            for conn, connection in reader.connections.items():
                if selected_ids is None or conn in selected_ids:
                    yield bag_index, connection

    def messages(self, start: int, end: int) -> Iterator[PlayItem]:
        """Yield messages in time order; messages with the same time are in the order of the bags.

        Args:
            start: earliest time in nanoseconds.
            end: latest time in nanoseconds.

        Raises:
            BagError: a chunk cannot be read.
        """
        streams = [self._bag_messages(bag_index, start, end) for bag_index in range(len(self.readers))]
        if len(streams) == 1:
            return streams[0]
        return heapq.merge(*streams, key=lambda item: item.message.time)

    def _bag_messages(self, bag_index: int, start: int, end: int) -> Iterator[PlayItem]:
        messages = self.readers[bag_index].messages(self._selected_ids[bag_index], start, end)
        return map(PlayItem, repeat(bag_index), messages)  # map() keeps no message while the next one is read

    def latched_messages_before(self, time: int) -> list[PlayItem]:
        """Return, for new subscribers, the last message before a time from each latched connection, in time order.

        For static transforms, the last message of a connection is not enough: bags that were written by Python
        programs, or filtered with other tools, store several publishers as one connection. So all static transforms at
        the beginning of the bag are returned as well.
        """
        items: list[PlayItem] = []
        for bag_index, reader in enumerate(self.readers):
            selected_ids = self._selected_ids[bag_index]
            connections = [
                connection
                for conn, connection in reader.connections.items()
                if selected_ids is None or conn in selected_ids
            ]
            static_ids = {connection.id for connection in connections if is_static_transforms(connection)}
            latched_ids = {connection.id for connection in connections if connection.latching}
            items += [PlayItem(bag_index, message) for message in _first_messages(reader, static_ids, time)]
            items += [
                PlayItem(bag_index, message)
                for message in _last_messages_before(reader, latched_ids | static_ids, time)
            ]
        items.sort(key=lambda item: item.message.time)
        return items

    def close(self) -> None:
        """Close the files."""
        for reader in self._opened:
            reader.close()

    def __enter__(self) -> BagSet:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _first_messages(reader: BagReader, conn_ids: set[int], time: int) -> Iterator[RawMessage]:
    """Yield the messages of the given connections before a time, from the first chunks that contain any of them."""
    chunks = [chunk for chunk in reader.chunks if chunk.start < time and not conn_ids.isdisjoint(chunk.counts)]
    for chunk in sorted(chunks, key=lambda chunk: chunk.start)[:_MAX_STATIC_CHUNKS]:
        content, messages = reader.content(chunk)
        for message in messages:
            if message.conn in conn_ids and message.time < time:
                data = content[message.start : message.end]
                yield RawMessage(reader.connections[message.conn], message.time, data)


def _last_messages_before(reader: BagReader, conn_ids: set[int], time: int) -> Iterator[RawMessage]:
    """Yield each given connection's last message before a time. Only chunks that may contain one are read."""
    latest: dict[int, RawMessage] = {}
    chunks = sorted((chunk for chunk in reader.chunks if chunk.start < time), key=lambda chunk: chunk.end, reverse=True)
    for chunk in chunks:
        candidates = {
            conn for conn in conn_ids & chunk.counts.keys() if conn not in latest or latest[conn].time < chunk.end
        }
        if not candidates:
            continue
        content, messages = reader.content(chunk)
        for message in messages:
            previous = latest.get(message.conn)
            if (
                message.conn in candidates
                and message.time < time
                and (previous is None or previous.time <= message.time)
            ):
                data = content[message.start : message.end]
                latest[message.conn] = RawMessage(reader.connections[message.conn], message.time, data)
    yield from latest.values()


class ReadAhead:
    """Fetches messages from an iterator in a thread, before they are needed. A context manager that ends the thread
    on exit.

    Args:
        messages: the iterator; nothing but the thread may use it.
        limit: maximum size in bytes of the messages fetched in advance.
    """

    def __init__(self, messages: Iterator[PlayItem], limit: int = MAX_AHEAD_BYTES) -> None:
        self._messages = messages
        self._limit = limit
        self._batches: deque[tuple[int, list[PlayItem]]] = deque()
        self._bytes = 0
        self._changed = threading.Condition()
        self._is_finished = False
        self._is_closed = False
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="bag:reader", daemon=True)
        self._thread.start()

    def take(self, timeout: float) -> list[PlayItem] | None:
        """Return the next messages: an empty list if none is ready yet, or None after the last one.

        Args:
            timeout: maximum number of seconds to wait for messages.

        Raises:
            BagError: a chunk cannot be read.
            OSError: the file cannot be read.
        """
        with self._changed:
            if not self._batches and not self._is_finished:
                self._changed.wait(timeout)
            if self._batches:
                size, batch = self._batches.popleft()
                self._bytes -= size
                self._changed.notify_all()
                return batch
            if self._is_finished and self._error is not None:
                raise self._error
            return None if self._is_finished else []

    def _run(self) -> None:
        try:
            self._read()
        except Exception as error:  # noqa: BLE001 - the other thread raises it
            self._error = error
        with self._changed:
            self._is_finished = True
            self._changed.notify_all()

    def _read(self) -> None:
        batch: list[PlayItem] = []
        size, batch_limit = 0, 1  # the first message at once, then in growing batches
        for item in self._messages:
            batch.append(item)
            size += len(item.message.data) + _MESSAGE_OVERHEAD
            del item  # so that a large message is not in memory while the next one is read
            if size >= _MAX_BATCH_BYTES or len(batch) >= batch_limit:
                if not self._put_batch(size, batch):
                    return
                batch, size, batch_limit = [], 0, min(2 * batch_limit, _MAX_BATCH_MESSAGES)
        if batch:
            self._put_batch(size, batch)

    def _put_batch(self, size: int, batch: list[PlayItem]) -> bool:
        with self._changed:
            self._batches.append((size, batch))
            self._bytes += size
            self._changed.notify_all()
            while self._bytes > self._limit and not self._is_closed:
                self._changed.wait()
            return not self._is_closed

    def close(self) -> None:
        """Stop the thread, and wait until it has ended."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        self._thread.join()

    def __enter__(self) -> ReadAhead:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
