"""Reads bags in Python: messages in time order, and topics as columns for numpy and pandas."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator
from types import TracebackType
from typing import IO, TYPE_CHECKING, Any, Literal, NamedTuple, overload

from pyros1.bag.columns import field_type, field_value, leaf_paths, to_array
from pyros1.bag.errors import BagError
from pyros1.bag.format.reader import BagReader, RawMessage
from pyros1.bag.format.records import Connection
from pyros1.bag.format.writer import CHUNK_THRESHOLD
from pyros1.bag.info import Summary, summarize
from pyros1.bag.writing import BagOutput
from pyros1.ground.errors import MessageError
from pyros1.ground.suggest import did_you_mean
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import AnyMsg, DefinitionCache, Message
from pyros1.msgs.array_views import find_view
from pyros1.msgs.base import View

if TYPE_CHECKING:
    from numpy.typing import NDArray

When = Time | Duration | float | None
"""A time in a bag: a Time is absolute; a Duration or seconds are relative to the bag's beginning or, if negative, to
its end.
"""

_TIME_FIELD_COLUMN = "time_"
"""Name of the column for a field ``time``: the column ``time`` holds the times at which messages were recorded."""


class BagMessage(NamedTuple):
    """A message from a bag.

    Attributes:
        topic: its topic, as recorded.
        message: the message; with ``raw=True`` an `AnyMsg`.
        time: the time at which it was recorded.
        connection: the publisher's connection, with its complete header.
    """

    topic: str
    message: Any
    time: Time
    connection: Connection


class Bag:
    """A bag open for reading; use it in a ``with`` statement.

    Args:
        path: path of the file, or an open binary file, which stays open when the bag is closed.
        unindexed: whether to also read bags that were not closed, by scanning them first.
        progress: called with the offset in bytes while the file is scanned.
        chunk_limit: see :class:`pyros1.bag.format.reader.BagReader`.

    Raises:
        BagError: the bag cannot be read; the message says why and what to do.
        OSError: the file cannot be opened.
    """

    reader_class: type[BagReader] = BagReader

    def __init__(
        self,
        path: str | os.PathLike[str] | IO[bytes],
        *,
        unindexed: bool = True,
        progress: Callable[[int], object] | None = None,
        chunk_limit: int | None = None,
    ) -> None:
        self.reader = self.reader_class(path, unindexed=unindexed, progress=progress, chunk_limit=chunk_limit)
        self._classes = DefinitionCache()
        self._class_by_id: dict[int, type[Message]] = {}

    @property
    def path(self) -> str:
        """Path of the file."""
        return self.reader.path

    @property
    def start(self) -> Time:
        """Time of the first message; 0 without messages."""
        return Time.from_nsec(self.reader.start)

    @property
    def end(self) -> Time:
        """Time of the last message; 0 without messages."""
        return Time.from_nsec(self.reader.end)

    @property
    def topics(self) -> dict[str, str]:
        """Topic -> message type, sorted by topic."""
        types = {connection.topic: connection.type for connection in self.reader.connections.values()}
        return dict(sorted(types.items()))

    @property
    def connections(self) -> list[Connection]:
        """All connections, sorted by id."""
        return [self.reader.connections[conn_id] for conn_id in sorted(self.reader.connections)]

    def __len__(self) -> int:
        return self.reader.count()

    def count(self, topics: str | Collection[str] | None = None) -> int:
        """Return the number of messages on the given topics; None means all topics."""
        return self.reader.count(self._connection_ids(topics))

    def summary(self, *, frequencies: bool = False) -> Summary:
        """Return the information that ``bag info`` prints; frequencies only if requested."""
        return summarize(self.reader, frequencies=frequencies)

    def messages(
        self,
        topics: str | Collection[str] | None = None,
        start: When = None,
        end: When = None,
        *,
        raw: bool = False,
        arrays: str | None = None,
        progress: Callable[[int, int], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages in time order. Only chunks that overlap the given time range are read.

        Args:
            topics: one topic or several; None means all. A leading ``/`` is ignored unless the bag has topics with and
                without it. Topics that are not in the bag yield nothing, as with rosbag.Bag.read_messages; the
                attribute `topics` lists the bag's topics.
            start: earliest time.
            end: latest time.
            raw: whether to yield `AnyMsg` instead of decoded messages.
            arrays: the type of arrays in messages, as for `pyros1.Node.subscribe`.
            progress: called after each message with the nanoseconds of bag time processed so far, and the total.

        Raises:
            BagError: the file is damaged, or a message cannot be decoded.
            ValueError: ``arrays`` is unknown.
        """
        view = find_view(arrays)
        first, last = self._to_nanoseconds(start), self._to_nanoseconds(end)
        begin = max(self.reader.start, first or 0)
        total = max(0, min(self.reader.end, self.reader.end if last is None else last) - begin)
        for stored in self.reader.messages(self._connection_ids(topics), first, last):
            message = self._raw_message(stored) if raw else self._decode(stored, view)
            connection, time = stored.connection, stored.time
            del stored  # it may be large, like the message below, and must be freed before the next message is read
            yield BagMessage(connection.topic, message, Time.from_nsec(time), connection)
            del message
            if progress is not None:
                progress(time - begin, total)

    __iter__ = messages

    def at(self, time: When, topics: str | Collection[str] | None = None) -> dict[str, BagMessage]:
        """Return the last message on each topic at or before a time: the messages that a late subscriber would receive
        if all topics were latched.

        Args:
            time: the time, absolute or relative as for :meth:`messages`.
            topics: one topic or several; None means all.

        Returns:
            Topic -> message, sorted by topic.

        Raises:
            BagError: as for :meth:`messages`.
        """
        conn_ids = self._connection_ids(topics)
        wanted_ids = set(self.reader.connections) if conn_ids is None else set(conn_ids)
        end = self._to_nanoseconds(time)
        latest: dict[str, RawMessage] = {}
        for chunk in sorted(self.reader.chunks, key=lambda chunk: chunk.end, reverse=True):
            wanted_topics = {self.reader.connections[conn].topic for conn in chunk.counts if conn in wanted_ids}
            if (end is not None and chunk.start > end) or not wanted_topics:
                continue
            if all(wanted_topic in latest and latest[wanted_topic].time >= chunk.end for wanted_topic in wanted_topics):
                continue
            content, entries = self.reader.content(chunk)
            for entry in entries:
                if entry.conn not in wanted_ids or (end is not None and entry.time > end):
                    continue
                connection = self.reader.connections[entry.conn]
                if connection.topic not in latest or latest[connection.topic].time <= entry.time:
                    data = content[entry.start : entry.end]
                    latest[connection.topic] = RawMessage(connection, entry.time, data)
        return {
            topic: BagMessage(topic, self.decode(stored), Time.from_nsec(stored.time), stored.connection)
            for topic, stored in sorted(latest.items())
        }

    def columns(
        self,
        topic: str,
        fields: Iterable[str] | None = None,
        start: When = None,
        end: When = None,
        *,
        progress: Callable[[int, int], object] | None = None,
    ) -> dict[str, list[Any]]:
        """Return a topic's messages as lists, one per field; `arrays` returns arrays for numpy and pandas.

        Args:
            topic: name of the topic.
            fields: paths such as ``pose.position.x`` or ``ranges``; None means all fields that are not arrays.
            start: as for :meth:`messages`.
            end: as for :meth:`messages`.
            progress: as for :meth:`messages`.

        Returns:
            A list for ``time``, in seconds since 1970, and one for each field; all have the same length. Times are in
            seconds. A field called ``time`` is named ``time_``.

        Raises:
            BagError: there is no such topic, or as for :meth:`messages`.
            AttributeError: there is no such field.
        """
        cls = self._topic_class(topic)
        times: list[float] = []
        columns: dict[str, list[Any]] | None = None if fields is None else {path: [] for path in fields}
        for bag_message in self.messages(topic, start, end, progress=progress):
            if columns is None:
                columns = {path: [] for path in leaf_paths(bag_message.message)}
            times.append(bag_message.time.to_sec())
            for path, values in columns.items():
                values.append(field_value(bag_message.message, path))
        if columns is None:
            columns = {path: [] for path in leaf_paths(cls())}
        named_columns = {_TIME_FIELD_COLUMN if path == "time" else path: values for path, values in columns.items()}
        return {"time": times, **named_columns}

    def arrays(
        self,
        topic: str,
        fields: Iterable[str] | None = None,
        start: When = None,
        end: When = None,
        *,
        progress: Callable[[int, int], object] | None = None,
    ) -> dict[str, NDArray[Any]]:
        """Return a topic's messages as arrays, one per field, for numpy and pandas::

            frame = pandas.DataFrame(bag.arrays("/odom")).set_index("time")
            speed = bag.arrays("/odom")["twist.twist.linear.x"].mean()

        Args:
            topic, fields, start, end, progress: as for :meth:`columns`.

        Returns:
            As :meth:`columns`, with arrays of shape (n,) and the fields' numeric types; strings are objects. A field
            that is an array of numbers has the shape (n, length) if it is equally long in all messages; otherwise it is
            an array of objects.

        Raises:
            BagError: as for :meth:`columns`.
            AttributeError: there is no such field.
        """
        columns = self.columns(topic, fields, start, end, progress=progress)
        cls = self._topic_class(topic)
        types = {name: field_type(cls, "time" if name == _TIME_FIELD_COLUMN else name) for name in columns}
        types["time"] = "float64"
        return {name: to_array(values, types.get(name, "")) for name, values in columns.items()}

    def decode(self, stored: RawMessage) -> Message:
        """Decode a stored message with the definition in the bag.

        Raises:
            BagError: the bytes cannot be decoded, or the definition is missing or wrong.
        """
        return self._decode(stored, None)

    def _decode(self, stored: RawMessage, view: View | None) -> Message:
        try:
            cls = self._class_by_id.get(stored.connection.id)
            if cls is None:
                cls = self._class_by_id[stored.connection.id] = self.message_class(stored.connection)
            message: Message
            if view is None:
                message = cls._decode(stored.data, 0, len(stored.data))
            else:
                message = cls._decode_arrays(stored.data, 0, len(stored.data), view)
        except MessageError as error:
            location = f"message on {stored.connection.topic} at {stored.time / 1e9:.6f}"
            raise BagError(self.path, f"{location}: {error}") from error
        return message

    def message_class(self, connection: Connection) -> type[Message]:
        """Return the class of a connection's messages.

        If the recorded definition is unusable, another one with the same name and md5 sum is used: that of another
        connection or of an installed type.

        Raises:
            DefinitionError: the definition is wrong.
            UnknownTypeError: the connection has no definition.
        """
        type_key = connection.type, connection.md5sum
        other_definitions = (
            other.definition for other in self.reader.connections.values() if (other.type, other.md5sum) == type_key
        )
        return self._classes.get(*type_key, connection.definition, other_definitions)

    def definition(self, connection: Connection) -> str:
        """Return the full definition of a connection's message type: the one that `message_class` uses or, if none is
        usable, the recorded text.
        """
        try:
            return self.message_class(connection)._full_text
        except MessageError:
            return connection.definition

    def close(self) -> None:
        """Close the file."""
        self.reader.close()

    def __enter__(self) -> Bag:
        return self

    def __exit__(
        self, error_type: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _connection_ids(self, topics: str | Collection[str] | None) -> set[int] | None:
        if topics is None:
            return None
        return self.reader.connection_ids([topics] if isinstance(topics, str) else topics)

    def _topic_class(self, topic: str) -> type[Message]:
        """Return the class of a topic's messages; raises BagError if the topic or its definition is missing."""
        ids = self.reader.connection_ids([topic])
        if not ids:
            known_topics = self.topics
            hint = did_you_mean(f"/{topic.lstrip('/')}", known_topics) or (
                "" if known_topics else "; the bag has no topics"
            )
            raise BagError(self.path, f"there is no topic {topic}{hint}")
        connection = self.reader.connections[min(ids)]
        try:
            return self.message_class(connection)
        except MessageError as error:
            raise BagError(self.path, f"the type of {connection.topic}: {error}") from error

    def _to_nanoseconds(self, when: When) -> int | None:
        if when is None:
            return None
        if isinstance(when, Time):
            return when.to_nsec()
        offset = when.to_nsec() if isinstance(when, Duration) else round(when * 1e9)
        return (self.reader.start if offset >= 0 else self.reader.end) + offset

    @staticmethod
    def _raw_message(stored: RawMessage) -> AnyMsg:
        connection = stored.connection
        return AnyMsg(stored.data, {name: connection.text(name) for name in connection.header})


@overload
def open(
    path: str | os.PathLike[str] | IO[bytes],
    mode: Literal["r"] = "r",
    *,
    unindexed: bool = True,
    progress: Callable[[int], object] | None = None,
    chunk_limit: int | None = None,
) -> Bag: ...


@overload
def open(
    path: str | os.PathLike[str] | IO[bytes],
    mode: Literal["w", "a"],
    *,
    compression: str = "none",
    chunk_threshold: int = CHUNK_THRESHOLD,
) -> BagOutput: ...


def open(
    path: str | os.PathLike[str] | IO[bytes],
    mode: str = "r",
    *,
    unindexed: bool = True,
    progress: Callable[[int], object] | None = None,
    chunk_limit: int | None = None,
    compression: str = "none",
    chunk_threshold: int = CHUNK_THRESHOLD,
) -> Bag | BagOutput:
    """Open a bag for reading or writing.

    ::

        with pyros1.bag.open("run.bag") as bag:
            for topic, message, time, _ in bag.messages("/odom", start=10.0):
                print(time, message.pose.pose.position.x)

        with pyros1.bag.open("new.bag", "w", compression="lz4") as bag:
            bag.write("/odom", message, stamp)

    Args:
        path: path of the file, or an open binary file, which stays open when the bag is closed.
        mode: ``r`` reads; ``w`` writes a new bag, replacing an existing file; ``a`` appends to the file.
        unindexed: when reading, whether to also read bags that were not closed.
        progress: when reading, called with the current offset in bytes while such a bag is scanned.
        chunk_limit: when reading, maximum uncompressed size of a chunk in bytes, since even a small file can claim any
            size. None means the value of the environment variable ``PYROS1_BAG_CHUNK_LIMIT``, in MiB, or 256 MiB if it
            is not set.
        compression: when writing, ``none``, ``bz2`` or ``lz4``.
        chunk_threshold: when writing, uncompressed size in bytes above which a chunk is closed.

    Raises:
        BagError: the bag cannot be read; the message says why and what to do.
        OSError: the file cannot be opened.
        ValueError: the mode or compression is unknown.
    """
    if mode == "r":
        return Bag(path, unindexed=unindexed, progress=progress, chunk_limit=chunk_limit)
    if mode in ("w", "a"):
        return BagOutput(path, more=mode == "a", compression=compression, chunk_threshold=chunk_threshold)
    raise ValueError(f"mode {mode!r}: use 'r', 'w' or 'a'")


def bag_topics(path: str | os.PathLike[str]) -> dict[str, tuple[str, int, int]]:
    """Return topic -> (type, number of messages, number of connections), sorted by topic; raises the same errors as
    :func:`open`.
    """
    with Bag(path) as bag:
        return {topic.name: (topic.type, topic.messages, topic.connections) for topic in bag.summary().topics}
