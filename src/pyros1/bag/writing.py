"""Writes new bags, or appends to existing ones, from Python; messages are objects or encoded bytes."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from types import TracebackType
from typing import IO, Any

from pyros1.bag.errors import BagError
from pyros1.bag.format.appending import open_for_append
from pyros1.bag.format.records import NS_PER_S
from pyros1.bag.format.writer import CHUNK_THRESHOLD, BagWriter
from pyros1.bag.serialized_operations import SerializedOperations
from pyros1.ground.timing import Time
from pyros1.msgs import AnyMsg, Message

Header = Mapping[str, str | bytes]
"""A connection header, for example a publisher's ``_connection_header``."""


class BagOutput:
    """A bag open for writing; use it in a ``with`` statement. Any thread or signal handler may write to it or close it.

    Until it is closed, the bag has no index: after a crash, `pyros1 bag reindex` recovers everything written except the
    last chunk. An exception in the ``with`` block closes the bag as usual, so it is complete up to that point.

    Args:
        target: path of the file, or a binary file that is open for reading and writing and stays open.
        more: whether to keep the content of the file and append to it; the file is created if it does not exist.
        compression: ``none``, ``bz2`` or ``lz4``.
        chunk_threshold: uncompressed size in bytes above which a chunk is closed.

    Raises:
        UnindexedError: with `more`, the bag was not closed; `pyros1 bag reindex` repairs it.
        BagError: with `more`, messages cannot be added to the file.
        OSError: the file cannot be created.
        ValueError: the compression is unknown.
    """

    def __init__(
        self,
        target: str | os.PathLike[str] | IO[bytes],
        *,
        more: bool = False,
        compression: str = "none",
        chunk_threshold: int = CHUNK_THRESHOLD,
    ) -> None:
        is_new = not more or (isinstance(target, (str, os.PathLike)) and not os.path.exists(target))
        self.writer = (BagWriter if is_new else open_for_append)(target, compression, chunk_threshold)
        self._conn_ids: dict[Any, int] = {}
        self._operations = SerializedOperations()

    @property
    def path(self) -> str:
        """Path of the file."""
        return self.writer.path

    @property
    def size(self) -> int:
        """Number of bytes written so far."""
        return self.writer.size

    def __len__(self) -> int:
        return self.writer.messages

    def write(
        self, topic: str, message: Message | AnyMsg, stamp: Time | float | None = None, header: Header | None = None
    ) -> None:
        """Write a message.

        Args:
            topic: name of its topic.
            message: the message; an `AnyMsg` is written as it was received.
            stamp: time at which it was received, as a Time or in seconds since 1970; None for now.
            header: the publisher's connection header. None means the header of the received `AnyMsg` or, for other
                messages, a header with topic and type. Messages of the same topic, type and header share one
                connection.

        Raises:
            SerializationError: a value does not fit its field; nothing is written then.
            BagError: the stamp cannot be stored, or the header has no type.
            ValueError: the bag is closed.
            OSError: the file cannot be written, for example because the disk is full. Earlier messages are kept.
        """
        cls: Any = type(message)
        if header is None and isinstance(message, AnyMsg):
            header = message._connection_header or {}
        data = cls._encode(message)
        if header is None:
            self._write_in_turn((topic, cls), topic, data, stamp, cls)
        else:
            self.write_raw(topic, data, header, stamp)

    def write_raw(
        self, topic: str, data: bytes | memoryview, header: Header, stamp: Time | float | None = None
    ) -> None:
        """Write an encoded message.

        Args:
            topic: name of its topic.
            data: the bytes of the message.
            header: connection header with at least ``type``, ``md5sum`` and ``message_definition``.
            stamp: as for :meth:`write`.

        Raises:
            BagError, ValueError, OSError: as for :meth:`write`.
        """
        self._write_in_turn((topic, *sorted(header.items())), topic, data, stamp, header)

    def _write_in_turn(
        self, key: Any, topic: str, data: bytes | memoryview, stamp: Time | float | None, header_or_class: Any
    ) -> None:
        self._operations.run(self._write, key, topic, data, _to_nanoseconds(stamp), header_or_class)

    def _write(self, key: Any, topic: str, data: bytes | memoryview, nanoseconds: int, header_or_class: Any) -> None:
        conn = self._conn_ids.get(key)
        if conn is None:
            conn = self._conn_ids[key] = self.writer.add_connection(topic, self._header_fields(header_or_class))
        self.writer.write(conn, nanoseconds, data)

    def _header_fields(self, header_or_class: Any) -> dict[str, bytes]:
        """Return a connection header with bytes as values, from a header with strings or bytes, or a message class."""
        if isinstance(header_or_class, type):
            cls: Any = header_or_class
            header_or_class = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text}
        fields = {
            name: value.encode("utf-8", "surrogateescape") if isinstance(value, str) else bytes(value)
            for name, value in header_or_class.items()
        }
        for name in ("type", "md5sum", "message_definition"):
            if name not in fields:
                raise BagError(self.path, f"the connection header of a message needs the field {name!r}")
        return fields

    def flush(self) -> None:
        """Pass all written data to the operating system, so that the data survive a crash of this process."""
        self._operations.run(self.writer.flush)

    def close(self) -> None:
        """Write the remaining data and the index, and close the file. A second call does nothing.

        Raises:
            OSError: the file cannot be written; it is closed anyway, and can be reindexed.
        """
        self._operations.run(self.writer.close)

    def __enter__(self) -> BagOutput:
        return self

    def __exit__(
        self, error_type: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


def _to_nanoseconds(stamp: Time | float | None) -> int:
    if stamp is None:
        return time.time_ns()
    return stamp.to_nsec() if isinstance(stamp, Time) else round(stamp * NS_PER_S)
