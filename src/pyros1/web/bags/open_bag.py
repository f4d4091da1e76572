"""An open bag, with one reader that all pages share."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.bag.api import Bag, BagMessage
from pyros1.bag.errors import BagError
from pyros1.bag.format.contents import Messages
from pyros1.bag.format.files import Chunk
from pyros1.bag.format.index import INDEX_ENTRY, entry_ranges
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import NS_PER_S
from pyros1.bag.info import summarize
from pyros1.ground.terminal_text import untrusted
from pyros1.ground.timing import Time
from pyros1.web.bags.density import Density
from pyros1.web.server.wire import RequestError

MAX_TOPICS = 5_000
"""Maximum number of topics displayed per bag."""
IMAGE_TYPES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")
_MAX_CACHED_BYTES = 64 << 20
"""Maximum size of the cached chunks in bytes, so that small movements of the cursor need no reading."""
_MAX_CACHED_TIMES = 4_000_000
"""Maximum number of cached message times, of 8 bytes each."""
_MAX_DISPLAYED_PLACES = 5
_MAX_CHUNKS_READ = 200
"""Maximum number of chunks whose index is read for one histogram. Reading that many takes up to 0.3 s."""
_MAX_CHUNKS_UNPACKED = 20
"""Like `_MAX_CHUNKS_READ`, but for bags without an index, whose chunks must be decompressed."""


@dataclass(frozen=True)
class BagTopic:
    """A topic in a bag.

    Attributes:
        name: the topic's name as recorded.
        type: the messages' type.
        count: number of messages.
        publishers: number of recorded connections, usually one per publisher.
    """

    name: str
    type: str
    count: int
    publishers: int


class OpenBag:
    """An open bag, as pages see it.

    Args:
        path: path of the file.
        may_see: returns whether pages may see a topic; called with the topic's name, with a leading slash.
        progress: called with the number of bytes read so far while a bag without an index is scanned; may raise an
            error to stop the scan.

    Attributes:
        bag: the bag's thread-safe reader.
        topics: the topics that pages may see, by name.
        begin, end: the times of the first and the last message, in nanoseconds.

    Raises:
        BagError: the bag cannot be read; the message says why and what to do.
        RequestError: the file cannot be opened.
    """

    def __init__(self, path: str, may_see: Callable[[str], bool], progress: Callable[[int], object]) -> None:
        try:
            self.bag: Bag = _SharedBag(path, progress=progress)
        except OSError as error:
            raise RequestError(f"{untrusted(path)}: {error.strerror or error}") from None
        try:
            self.topics = self._visible_topics(may_see)
            self.begin, self.end = self.bag.reader.start, self.bag.reader.end
            self._row_by_topic = {name: row for row, name in enumerate(self.topics)}
            connections = self.bag.reader.connections
            row_by_conn = {
                conn: self._row_by_topic.get(connection.topic, -1) for conn, connection in connections.items()
            }
            self._row_by_conn = row_by_conn
            self._density = Density(
                (chunk.start, chunk.end, [(row_by_conn.get(conn, -1), count) for conn, count in chunk.counts.items()])
                for chunk in self.bag.reader.chunks
            )
        except BaseException:
            self.bag.close()
            raise
        self._cached_times: OrderedDict[int, list[tuple[int, NDArray[np.int64]]]] = OrderedDict()
        self._num_cached_times = 0
        self._lock = threading.Lock()

    @property
    def length(self) -> float:
        """Seconds between the first and the last message."""
        return (self.end - self.begin) / NS_PER_S

    def nanoseconds(self, seconds: float) -> int:
        """Convert a time in seconds since the bag's start to an absolute time in nanoseconds."""
        return self.begin + round(seconds * NS_PER_S)

    def seconds(self, time: int) -> float:
        """Convert an absolute time in nanoseconds to seconds since the bag's start."""
        return (time - self.begin) / NS_PER_S

    def describe(self) -> dict[str, Any]:
        """Return a description of the bag's contents, for a page."""
        reader = self.bag.reader
        problems = []
        try:
            summary = summarize(reader)
            storage = {name: [entry.chunks, entry.size, entry.stored_size] for name, entry in summary.storage.items()}
            version, encryption = summary.version, summary.encryption
        except BagError as error:
            storage, version, encryption = {}, "2.0", reader.file.encryptor_name
            problems.append(str(error))
        if reader.file.version == 102:
            problems.append(
                "an old bag of version 1.2, which has no times in its index; `pyros1 bag reindex` converts it"
            )
        elif reader.was_scanned:
            problems.append(
                "this bag was not closed, or is damaged, so all of it had to be read; `pyros1 bag reindex` repairs it"
            )
        problems += [
            f"at byte {damage.offset}: {untrusted(damage.reason)}"
            for damage in reader.damaged_places[:_MAX_DISPLAYED_PLACES]
        ]
        if len(reader.damaged_places) > _MAX_DISPLAYED_PLACES:
            problems.append(f"and {len(reader.damaged_places) - _MAX_DISPLAYED_PLACES} more damaged places")
        topics = list(self.topics.values())[:MAX_TOPICS]
        return {
            "path": untrusted(reader.path),
            "size": reader.file.size,
            "version": version,
            "encryption": encryption,
            "storage": storage,
            "start": self.begin / NS_PER_S,
            "length": self.length,
            "messages": sum(topic.count for topic in self.topics.values()),
            "topics": [
                {
                    "name": untrusted(topic.name),
                    "type": untrusted(topic.type),
                    "count": topic.count,
                    "publishers": topic.publishers,
                    "image": topic.type in IMAGE_TYPES,
                }
                for topic in topics
            ],
            "more": max(0, len(self.topics) - len(topics)),
            "problems": problems,
        }

    def recorded_names(self, names: Iterable[str]) -> list[str]:
        """Return the recorded forms of topic names; names of missing topics are omitted."""
        return [topic.name for name in names if (topic := self.topic(name)) is not None]

    def topic(self, name: str) -> BagTopic | None:
        """Return the named topic; None if there is none. A missing or superfluous leading slash in the name does not
        matter.
        """
        other_form = name[1:] if name.startswith("/") else f"/{name}"
        return self.topics.get(name) or self.topics.get(other_form)

    def histogram(self, begin: float, end: float, columns: int, topics: list[str]) -> tuple[NDArray[np.float32], bool]:
        """Return the numbers of messages per column; see `Density.histogram`. Times are in seconds since the start."""
        first = self.nanoseconds(begin)
        last = max(first + columns, self.nanoseconds(end))
        rows = [self._row_by_topic[name] for name in topics]
        max_chunks = _MAX_CHUNKS_UNPACKED if self.bag.reader.was_scanned else _MAX_CHUNKS_READ
        return self._density.histogram(first, last, columns, rows, self._chunk_times, max_chunks)

    def messages_at(self, time: float, topics: Collection[str]) -> dict[str, BagMessage]:
        """Return topic -> its last message at or before a time in seconds since the bag's start."""
        return self.bag.at(Time.from_nsec(max(0, self.nanoseconds(time))), topics) if topics else {}

    def adjacent_time(self, time: float, topics: Collection[str], forward: bool) -> float | None:
        """Return the time of the next or the previous message on any of the topics; None if there is no such message.

        Args:
            time: the time from which to search; like the result, in seconds since the bag's start.
            topics: the recorded names of the topics.
            forward: whether to search for the next message instead of the previous one.
        """
        nanoseconds = self.nanoseconds(time)
        ids = self.bag.reader.connection_ids(topics)
        if forward:
            return next(
                (self.seconds(message.time) for message in self.bag.reader.messages(ids, nanoseconds + 1)), None
            )
        if nanoseconds <= self.begin:
            return None
        previous = self.bag.at(Time.from_nsec(nanoseconds - 1), topics)
        return max((self.seconds(message.time.to_nsec()) for message in previous.values()), default=None)

    def find_topic(self, text: str) -> tuple[str, str, str] | None:
        """Split ``/topic/field`` into the topic's recorded name, its type, and the field path; None if there is no
        such topic.
        """
        parts = text.split("/")
        for size in range(len(parts), 0, -1):
            topic = self.topic("/".join(parts[:size]))
            if topic is not None:
                return topic.name, topic.type, "/".join(("", *parts[size:])) if parts[size:] else ""
        return None

    def close(self) -> None:
        """Close the file."""
        self.bag.close()

    def _visible_topics(self, may_see: Callable[[str], bool]) -> dict[str, BagTopic]:
        reader = self.bag.reader
        counts: dict[int, int] = {}
        for chunk in reader.chunks:
            for conn, count in chunk.counts.items():
                counts[conn] = counts.get(conn, 0) + count
        topics: dict[str, BagTopic] = {}
        for conn, connection in reader.connections.items():
            name = connection.topic
            if may_see("/" + name.lstrip("/")):
                topic_so_far = topics.get(name, BagTopic(name, connection.type, 0, 0))
                count = topic_so_far.count + counts.get(conn, 0)
                topics[name] = BagTopic(name, topic_so_far.type, count, topic_so_far.publishers + 1)
        return dict(sorted(topics.items()))

    def _chunk_times(self, number: int) -> Iterable[tuple[int, NDArray[np.int64]]]:
        """Return a chunk's row numbers, each with the times of its messages; see `ReadTimes`."""
        with self._lock:
            times_by_row = self._cached_times.get(number)
            if times_by_row is not None:
                self._cached_times.move_to_end(number)
        if times_by_row is None:
            times_by_row = self._read_times(self.bag.reader.chunks[number])
            with self._lock:
                self._cached_times[number] = times_by_row
                self._num_cached_times += sum(len(times) for _, times in times_by_row)
                while self._num_cached_times > _MAX_CACHED_TIMES and len(self._cached_times) > 1:
                    _, dropped = self._cached_times.popitem(last=False)
                    self._num_cached_times -= sum(len(times) for _, times in dropped)
        return times_by_row

    def _read_times(self, chunk: Chunk) -> list[tuple[int, NDArray[np.int64]]]:
        reader = self.bag.reader
        index_ranges = None if reader.was_scanned else entry_ranges(reader.file, chunk, reader.header(chunk))
        if index_ranges is None:
            messages = reader.content(chunk)[1]
            conns, times = np.asarray(messages.conns, np.int64), np.asarray(messages.times, np.int64)
            return [(self._row_by_conn.get(int(conn), -1), times[conns == conn]) for conn in np.unique(conns)]
        by_row = []
        for conn, start, size in index_ranges:
            data = reader.file.read(start, size)
            entries = np.frombuffer(data[: len(data) // INDEX_ENTRY.size * INDEX_ENTRY.size], "<u4").reshape(-1, 3)
            by_row.append((self._row_by_conn.get(conn, -1), entries[:, 0].astype(np.int64) * NS_PER_S + entries[:, 1]))
        return by_row


class _CachingReader(BagReader):
    """Caches the most recently used chunks, up to `_MAX_CACHED_BYTES`."""

    def __init__(self, *args: Any, **options: Any) -> None:
        self._cache: OrderedDict[int, tuple[bytes, Messages]] = OrderedDict()
        self._cache_size = 0
        self._cache_lock = threading.Lock()
        super().__init__(*args, **options)

    def content(self, chunk: Chunk) -> tuple[bytes, Messages]:
        with self._cache_lock:
            cached_content = self._cache.get(chunk.pos)
            if cached_content is not None:
                self._cache.move_to_end(chunk.pos)
                return cached_content
        new_content = super().content(chunk)
        size = _content_size(new_content)
        if size <= _MAX_CACHED_BYTES // 4:
            with self._cache_lock:
                if chunk.pos not in self._cache:
                    self._cache[chunk.pos] = new_content
                    self._cache_size += size
                while self._cache_size > _MAX_CACHED_BYTES:
                    self._cache_size -= _content_size(self._cache.popitem(last=False)[1])
        return new_content


class _SharedBag(Bag):
    reader_class = _CachingReader


def _content_size(content: tuple[bytes, Messages]) -> int:
    return len(content[0]) + Messages.BYTES_PER_MESSAGE * len(content[1])
