"""The bag (https://wiki.ros.org/rosbag/Code%20API)."""

from __future__ import annotations

import io
import os
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from rospy.rostime import Time

from pyros1.bag.errors import UnindexedError
from pyros1.bag.format.appending import open_for_append
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.writer import BagWriter
from pyros1.bag.info import frequency_text as _human_readable_frequency
from pyros1.bag.info import size_text as _human_readable_size
from pyros1.drop_in.module_attributes import module_getattr
from rosbag._info import ComparableMixin, InfoMixin
from rosbag._messages import find_decoder, make_bag_message, read_version, to_nanoseconds
from rosbag._reader_pool import ReaderPool
from rosbag._reindexing import rebuild_index
from rosbag._types import (
    BagMessage,
    BagMessageWithConnectionHeader,
    Compression,
    CompressionTuple,
    ROSBagEncryptException,
    ROSBagEncryptNotSupportedException,
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
    TopicTuple,
    TypesAndTopicsTuple,
    _ChunkHeader,
    _ChunkInfo,
    _ConnectionInfo,
    _get_message_type,
    _IndexEntry200,
    _message_types,
    stock_errors,
    to_connection_info,
)
from rosbag._writing import CLOSED_BAG_MESSAGE, WritingMixin

found_lz4 = True
"""Whether chunks can be compressed with lz4: pyros1 always can."""
__getattr__ = module_getattr(__name__)


class Bag(WritingMixin, InfoMixin):
    """A bag open for reading or writing.

    Args:
        f: path of the file, or an open binary file, which is closed with the bag.
        mode: ``r`` reads, ``w`` writes a new bag, ``a`` appends. Bags open for writing can also be read.
        compression: ``none``, ``bz2`` or ``lz4``.
        chunk_threshold: uncompressed size in bytes beyond which a chunk is closed.
        allow_unindexed: whether to open a bag that was not closed; it appears to be empty until `reindex`.
        options: a mapping with ``compression`` and ``chunk_threshold``, which replace the arguments.
        skip_index: accepted for compatibility; the index is always read when it is first needed.

    Raises:
        ValueError: an argument is invalid.
        ROSBagException: the file is not a bag.
        ROSBagFormatException: the bag cannot be read.
        ROSBagUnindexedException: the bag was not closed.
        OSError: the file cannot be opened.
    """

    def __init__(
        self,
        f: Any,
        mode: str = "r",
        compression: str = Compression.NONE,
        chunk_threshold: int = 768 * 1024,
        allow_unindexed: bool = False,
        options: Any = None,
        skip_index: bool = False,
    ) -> None:
        if options is not None:
            if not isinstance(options, dict):
                raise ValueError("options must be of type dict")
            compression = options.get("compression", compression)
            chunk_threshold = options.get("chunk_threshold", chunk_threshold)
        self._file: Any = None
        super().__init__(mode, compression, chunk_threshold)
        if not f or not (isinstance(f, (str, os.PathLike)) or hasattr(f, "read")):
            raise ValueError("filename (or stream) is invalid")
        if mode not in ("r", "w", "a"):
            raise ValueError(f'mode "{mode}" is invalid')
        self._version = 200
        self._cipher: Any = None
        is_path = isinstance(f, (str, os.PathLike))
        self._filename = os.fspath(f) if is_path else None
        self._file = open(f, {"r": "rb", "w": "w+b", "a": "a+b"}[mode]) if is_path else f  # noqa: SIM115
        self._cached_reader: tuple[int, BagReader] | None = None
        self._readers = ReaderPool(self._operations.lock)
        try:
            with stock_errors():
                self._open(allow_unindexed)
        except BaseException:
            self.close()
            raise

    @property
    def _target(self) -> Any:
        return self._file if self._filename is None else self._filename

    def _open(self, allow_unindexed: bool) -> None:
        if self._mode == "w":
            self._writer = BagWriter(self._target, self._compression, self._chunk_threshold)
            return
        self._version = read_version(self._file)
        if self._mode == "a" and self._version != 200:
            raise ROSBagException(f"bag version {self._version} is unsupported for appending")
        if self._version not in (200, 102):
            raise ROSBagException(f"unknown bag version {self._version}")
        try:
            if self._mode == "a":
                self._writer = open_for_append(self._target, self._compression, self._chunk_threshold)
            else:
                self._cached_reader = -1, BagReader(self._target)
        except UnindexedError:
            if not allow_unindexed:
                raise
            self._cached_reader = -1, BagReader(self._target, unindexed=True)
            self._cached_reader[1].connections, self._cached_reader[1].chunks = {}, []

    def __iter__(self) -> Iterator[Any]:
        return self.read_messages()

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, exc_type: Any, exc_value: Any, traceback: Any) -> None:
        self.close()

    # Properties -------------------------------------------------------------------------------------------------------

    @property
    def filename(self) -> str | None:
        """Path of the file; None for a file object."""
        return self._filename

    @property
    def version(self) -> int:
        """Version of the format, 200 for 2.0."""
        return self._version

    @property
    def mode(self) -> str:
        """The mode in which the bag was opened."""
        return self._mode

    @property
    def size(self) -> int:
        """Size of the file in bytes, including data not written yet."""
        if not self._file:
            raise ValueError(CLOSED_BAG_MESSAGE)
        if self._writer is not None:
            return self._writer.size
        position = self._file.tell()
        size: int = self._file.seek(0, os.SEEK_END)
        self._file.seek(position)
        return size

    # Reading ----------------------------------------------------------------------------------------------------------

    @property
    def _reader(self) -> BagReader:
        """The reader of the file."""
        if self._writer is None:
            assert self._cached_reader is not None
            return self._cached_reader[1]
        with self._operations.lock:
            if self._file:
                self._operations.run(self._writer.flush)
            chunk_count = len(self._writer.chunks)
            if self._cached_reader is None or self._cached_reader[0] != chunk_count:
                self._readers.retire(self._cached_reader and self._cached_reader[1])
                self._cached_reader = chunk_count, BagReader(self._target, unfinished_writer=self._writer)
            return self._cached_reader[1]

    def read_messages(
        self,
        topics: Any = None,
        start_time: Any = None,
        end_time: Any = None,
        connection_filter: Callable[..., bool] | None = None,
        raw: bool = False,
        return_connection_header: bool = False,
    ) -> Iterator[Any]:
        """Return an iterator over messages, in order of time.

        Args:
            topics: one topic or several; none means all.
            start_time: genpy.Time of the earliest message.
            end_time: genpy.Time of the latest message.
            connection_filter: called with topic, type, md5 sum, definition and header of each connection; returns
                whether to read its messages.
            raw: whether messages are tuples of type, bytes, md5 sum, position and class.
            return_connection_header: whether the tuples also contain the connection header.

        Yields:
            BagMessage: topic, message and time; or BagMessageWithConnectionHeader.
        """
        self.flush()
        infos = {info.id: info for info in self._get_connections(topics, connection_filter)}
        return self._read(infos, start_time, end_time, raw, return_connection_header)

    def _read(
        self, infos: dict[int, Any], start_time: Any, end_time: Any, raw: bool, with_header: bool
    ) -> Iterator[Any]:
        first, last = to_nanoseconds(start_time), to_nanoseconds(end_time)
        ids = infos.keys()
        ranks = {conn_id: rank for rank, conn_id in enumerate(ids)}  # order of messages with the same time
        decoders: dict[int, Any] = {}
        with self._readers.use(lambda: self._reader) as reader, stock_errors():
            if raw:
                for stored in reader.located_messages(ids, first, last, ranks=ranks):
                    info = infos[stored.connection.id]
                    message = (info.datatype, stored.data, info.md5sum, stored.location, _get_message_type(info))
                    yield make_bag_message(info, message, Time.from_nsec(stored.time), with_header)
                return
            for connection, nanoseconds, data in reader.messages(ids, first, last, ranks=ranks):
                conn_id = connection.id
                decode = decoders.get(conn_id)
                if decode is None:
                    decode = decoders[conn_id] = find_decoder(_get_message_type(infos[conn_id]))
                message = decode(data, 0, len(data))
                if with_header:
                    yield make_bag_message(infos[conn_id], message, Time.from_nsec(nanoseconds), with_header)
                else:
                    yield BagMessage(connection.topic, message, Time.from_nsec(nanoseconds))

    def close(self) -> None:
        """Close the bag, if it is open."""
        self._operations.run(self._close)

    def _close(self) -> None:
        if not self._file:
            return
        try:
            if self._writer is not None:
                self._writer.close()
                self._reader.close()  # closes the file; the reader keeps the index
        finally:
            if self._cached_reader is not None:
                self._cached_reader[1].close()
            file, self._file = self._file, None
            file.close()

    def reindex(self) -> Iterator[int]:
        """Find all messages of a bag without using its index; with mode ``a`` the file gets a new index.

        Yields the offset in the file, in bytes, of each chunk.
        """
        if not self._file:
            raise ValueError(CLOSED_BAG_MESSAGE)
        return self._reindex()

    def _reindex(self) -> Iterator[int]:
        with stock_errors():
            if self._writer is not None and (self._mode == "w" or self._filename is None):
                self.flush()
                yield from [chunk.pos for chunk in self._reader.chunks]
                return
            if self._mode == "a":
                self._writer = rebuild_index(self._filename, self._writer, self._compression, self._chunk_threshold)
            reader = BagReader(self._target, unindexed=True)
            yield from [chunk.pos for chunk in reader.chunks]
            if self._mode == "a":
                reader.close()
            else:
                self._cached_reader = -1, reader

    def _read_message(self, position: Any, raw: bool = False, return_connection_header: bool = False) -> Any:
        self.flush()
        with self._readers.use(lambda: self._reader) as reader, stock_errors():
            stored = reader.at(position)
            info = to_connection_info(stored.connection)
            cls = _get_message_type(info)
            message: Any = (info.datatype, stored.data, info.md5sum, position, cls)
            message = message if raw else find_decoder(cls)(stored.data, 0, len(stored.data))
        return make_bag_message(info, message, Time.from_nsec(stored.time), return_connection_header)
