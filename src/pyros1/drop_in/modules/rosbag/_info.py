"""Information about a bag's messages, and the internal parts of its index that tools use."""

from __future__ import annotations

import heapq
import operator
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import yaml

from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import NS_PER_S
from pyros1.bag.info import Summary, info_text, info_values, summarize, summarize_topics, yaml_text
from pyros1.drop_in.module_attributes import class_getattr
from pyros1.ground.names import canonicalize_name
from rosbag._reader_pool import ReaderPool
from rosbag._types import (
    Compression,
    CompressionTuple,
    ROSBagException,
    TopicTuple,
    TypesAndTopicsTuple,
    _ChunkHeader,
    _ChunkInfo,
    _ConnectionInfo,
    _IndexEntry200,
    stock_errors,
    to_chunk_header,
    to_chunk_info,
    to_connection_info,
    to_index_entry,
)

_MISSING_NAMES = frozenset(
    [
        "_buffer",
        "_chunk_count",
        "_chunk_open",
        "_chunk_threshold",
        "_connection_count",
        "_connection_indexes",
        "_connection_indexes_read",
        "_curr_chunk_connection_indexes",
        "_curr_chunk_data_pos",
        "_curr_chunk_info",
        "_curr_compression",
        "_encryptor",
        "_file_header_pos",
        "_index_data_pos",
        "_mode",
        "_read_version",
        "_topic_connections",
    ]
)


class InfoMixin:
    """Base class of `rosbag.bag.Bag`: information about messages and about the index."""

    __getattr__ = class_getattr(
        "rosbag.Bag", "see get_type_and_topic_info, read_messages and pyros1.bag", _MISSING_NAMES
    )

    _file: Any
    _compression: str
    _readers: ReaderPool

    @property
    def _target(self) -> Any:
        raise NotImplementedError

    @property
    def _reader(self) -> BagReader:
        raise NotImplementedError

    def get_compression_info(self) -> Any:
        """Return the most frequent compression, and the size in bytes of all chunks before and after compression."""
        headers = list(self._chunk_headers.values())
        sizes = sum(header.uncompressed_size for header in headers), sum(header.compressed_size for header in headers)
        names = [header.compression for header in headers]
        most_common = max(names, key=lambda name: (names.count(name), name), default=self._compression)
        return CompressionTuple(most_common, *sizes)

    def get_message_count(self, topic_filters: Any = None) -> int:
        """Return the number of messages on some topics, or on all."""
        if topic_filters is None:
            return self._reader.count()
        return sum(topic.message_count for topic in self.get_type_and_topic_info(topic_filters).topics.values())

    def get_start_time(self) -> float:
        """Return the start time of the first chunk in seconds; raise ROSBagException if there are no messages."""
        return self._boundary_time(0) / NS_PER_S

    def get_end_time(self) -> float:
        """Return the time of the last message in seconds; raise ROSBagException if there are no messages."""
        return self._boundary_time(-1) / NS_PER_S

    def _boundary_time(self, index: int) -> int:
        chunks = self._reader.chunks
        if not chunks:
            raise ROSBagException("Bag contains no message")
        return chunks[index].end if index else chunks[0].start  # the last or first chunk in the file, as in stock ROS

    def get_type_and_topic_info(self, topic_filters: Any = None) -> Any:
        """Return types with their md5 sums, and topics with type, number of messages and connections, and frequency.

        Args:
            topic_filters: the topics to include: one name or a list; None means all.
        """
        with self._reader_even_if_closed() as reader:
            used_connections = {conn for chunk in reader.chunks for conn in chunk.counts}
            infos = [
                to_connection_info(connection)
                for number, connection in reader.connections.items()
                if number in used_connections
            ]
            names = [info.topic for info in infos] if topic_filters is None else topic_filters
            groups = {}
            for name in set(names if isinstance(names, list) else [names]):
                ids = [info.id for info in _select_connections(infos, name)]
                if ids:
                    groups[name] = ids
            summaries = summarize_topics(reader, groups, frequencies=True)
        types = {info.datatype: info.md5sum for info in reversed(infos)}
        topics = {
            summary.name: TopicTuple(summary.type, summary.messages, summary.connections, summary.frequency)
            for summary in summaries
        }
        return TypesAndTopicsTuple(dict(sorted(types.items())), topics)

    @contextmanager
    def _reader_even_if_closed(self) -> Iterator[BagReader]:
        """Yield the reader; for a closed bag, a reader of the file, which is opened again."""
        with stock_errors():
            if self._file:
                with self._readers.use(lambda: self._reader) as reader:  # another thread may replace the reader
                    yield reader
            else:
                with BagReader(self._target) as reader:
                    yield reader

    def _summary(self) -> Summary:
        with self._reader_even_if_closed() as reader:
            return summarize(reader, frequencies=True)

    def __str__(self) -> str:
        if not self._file:
            raise ValueError("I/O operation on closed bag")
        return info_text(self._summary())

    def _get_yaml_info(self, key: str | None = None) -> Any:
        text = yaml_text(info_values(self._summary()))
        if key is None:
            return text
        value = yaml.safe_load(text).get(key)
        if value is None:
            print(f'Error getting key "{key}"', file=sys.stderr)
        elif isinstance(value, list):
            return yaml.safe_dump(value, default_flow_style=False, sort_keys=False)
        return None if value is None else str(value)

    # Private members that some tools use to access the index ----------------------------------------------------------

    @property
    def _connections(self) -> dict[int, _ConnectionInfo]:
        return {number: to_connection_info(connection) for number, connection in self._reader.connections.items()}

    @property
    def _chunks(self) -> list[_ChunkInfo]:
        return [to_chunk_info(chunk) for chunk in self._reader.chunks]

    @property
    def _chunk_headers(self) -> dict[int, _ChunkHeader]:
        with self._reader_even_if_closed() as reader:
            return {
                chunk.pos: to_chunk_header(header)
                for chunk, header in zip(reader.chunks, reader.headers(), strict=True)
            }

    @property
    def _has_compressed_chunks(self) -> bool:
        return any(header.compression != Compression.NONE for header in self._chunk_headers.values())

    @property
    def _uncompressed_size(self) -> int:
        return sum(header.uncompressed_size for header in self._chunk_headers.values())

    def _get_connections(self, topics: Any = None, connection_filter: Callable[..., bool] | None = None) -> Any:
        for info in _select_connections(self._connections.values(), topics):
            if connection_filter and not connection_filter(
                info.topic, info.datatype, info.md5sum, info.msg_def, info.header
            ):
                continue
            yield info

    def _get_indexes(self, connections: Any) -> list[list[_IndexEntry200]]:
        entries_by_connection: dict[int, list[Any]] = {number: [] for number in self._reader.connections}
        with self._readers.use(lambda: self._reader) as reader:
            for entry in reader.entries():
                if entry.conn in entries_by_connection:
                    entries_by_connection[entry.conn].append(entry)
        ids = list(entries_by_connection) if connections is None else [info.id for info in connections]
        return [
            [to_index_entry(entry) for entry in sorted(entries_by_connection[number], key=lambda entry: entry.time)]
            for number in ids
        ]

    def _get_entries(self, connections: Any = None, start_time: Any = None, end_time: Any = None) -> Iterator[Any]:
        for entry in heapq.merge(*self._get_indexes(connections), key=lambda entry: entry.time):
            if start_time and entry.time < start_time:
                continue
            if end_time and entry.time > end_time:
                return
            yield entry

    def _get_entries_reverse(
        self, connections: Any = None, start_time: Any = None, end_time: Any = None
    ) -> Iterator[Any]:
        indexes = [index[::-1] for index in self._get_indexes(connections)]
        for entry in heapq.merge(*indexes, key=lambda entry: entry.time, reverse=True):
            if end_time and entry.time > end_time:
                continue
            if start_time and entry.time < start_time:
                return
            yield entry

    def _get_entry(self, t: Any, connections: Any = None) -> Any:
        return next(self._get_entries_reverse(connections, None, t), None)

    def _get_entry_after(self, t: Any, connections: Any = None) -> Any:
        return next((entry for entry in self._get_entries(connections, t) if entry.time > t), None)


def _select_connections(infos: Iterable[_ConnectionInfo], topics: Any) -> Iterator[_ConnectionInfo]:
    """Yield the connections of one or several topics, or of all topics if none is given. Repeated and trailing slashes
    in names are ignored.
    """
    selected_topics = {*map(canonicalize_name, [topics] if isinstance(topics, str) else topics)} if topics else None
    for info in infos:
        if selected_topics is None or canonicalize_name(info.topic) in selected_topics:
            yield info


class ComparableMixin:
    """Mixin that compares objects by the key that their ``_cmpkey()`` returns."""

    __slots__ = ()
    _cmpkey: Callable[[], Any]

    def __lt__(self, other: Any) -> bool:
        return self._compare(other, operator.lt)

    def __le__(self, other: Any) -> bool:
        return self._compare(other, operator.le)

    def __eq__(self, other: object) -> bool:
        return self._compare(other, operator.eq)

    def __ge__(self, other: Any) -> bool:
        return self._compare(other, operator.ge)

    def __gt__(self, other: Any) -> bool:
        return self._compare(other, operator.gt)

    __hash__ = None  # type: ignore[assignment]  # as in stock ROS: the key can change

    def _compare(self, other: Any, operation: Callable[[Any, Any], bool]) -> bool:
        if not (callable(getattr(self, "_cmpkey", None)) and callable(getattr(other, "_cmpkey", None))):
            return NotImplemented
        return operation(self._cmpkey(), other._cmpkey())
