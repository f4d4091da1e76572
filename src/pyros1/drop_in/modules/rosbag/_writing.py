"""Writes bags: messages, compression and encryption."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from typing import Any

from pyros1.bag.errors import BagError
from pyros1.bag.format.compression import COMPRESSIONS
from pyros1.bag.format.encryption import ENCRYPTORS, NO_ENCRYPTOR, new_cipher
from pyros1.bag.format.records import NS_PER_S
from pyros1.bag.format.writer import BagWriter
from pyros1.bag.serialized_operations import SerializedOperations
from rosbag._messages import find_encoder, header_fields
from rosbag._types import (
    ROSBagEncryptNotSupportedException,
    ROSBagException,
    ROSBagFormatException,
    _ConnectionInfo,
    stock_errors,
)

CLOSED_BAG_MESSAGE = "I/O operation on closed bag"


class WritingMixin:
    """Base class of `rosbag.bag.Bag` that writes messages. Callbacks in several threads, and signal handlers, may write
    at the same time.

    Args:
        mode, compression, chunk_threshold: see `rosbag.bag.Bag`.

    Raises:
        ValueError: an argument is invalid.
    """

    _file: Any

    def __init__(self, mode: str, compression: str, chunk_threshold: int) -> None:
        self._mode = mode
        self._operations = SerializedOperations()
        self._writer: BagWriter | None = None
        self._check_compression(compression)
        self._check_threshold(chunk_threshold)
        self._compression = compression
        self._chunk_threshold = chunk_threshold
        self._topic_connections: dict[Any, int] = {}
        self._encoders: dict[Any, Callable[[Any], bytes]] = {}

    @property
    def _target(self) -> Any:
        raise NotImplementedError

    @property
    def options(self) -> dict[str, Any]:
        """Compression and chunk threshold for writing."""
        return {"compression": self._compression, "chunk_threshold": self._chunk_threshold}

    @property
    def compression(self) -> str:
        """Compression of the chunks that are written from now on."""
        return self._compression

    @compression.setter
    def compression(self, compression: str) -> None:
        self._check_compression(compression)
        self.flush()
        self._compression = compression
        if self._writer is not None:
            self._writer.compression = compression

    @property
    def chunk_threshold(self) -> int:
        """Size in bytes beyond which a chunk is closed."""
        return self._chunk_threshold

    @chunk_threshold.setter
    def chunk_threshold(self, chunk_threshold: int) -> None:
        self._check_threshold(chunk_threshold)
        self.flush()
        self._chunk_threshold = chunk_threshold
        if self._writer is not None:
            self._writer.chunk_threshold = chunk_threshold

    @staticmethod
    def _check_compression(compression: str) -> None:
        if compression not in COMPRESSIONS:
            raise ValueError(f"compression must be one of: {', '.join(COMPRESSIONS)}")

    @staticmethod
    def _check_threshold(chunk_threshold: int) -> None:
        if chunk_threshold < 0:
            raise ValueError("chunk_threshold must be greater than or equal to zero")

    def write(self, topic: str, msg: Any, t: Any = None, raw: bool = False, connection_header: Any = None) -> None:
        """Write a message.

        Args:
            topic: name of the topic.
            msg: the message; with `raw` a tuple of type, bytes, md5 sum and class, as `read_messages` yields it.
            t: genpy.Time of the message; None for the current time.
            raw: whether `msg` is such a tuple.
            connection_header: header of the topic's connection; only used for its first message.

        Raises:
            ValueError: an argument is invalid, or the bag is closed.
            SerializationError: a value does not fit its field.
            OSError: the file cannot be written, for example because the disk is full.
        """
        if not self._file:
            raise ValueError(CLOSED_BAG_MESSAGE)
        if self._writer is None:
            raise io.UnsupportedOperation("write")
        if not topic:
            raise ValueError("topic is invalid")
        if not msg:
            raise ValueError("msg is invalid")
        nanoseconds = time.time_ns() if t is None else t.secs * NS_PER_S + t.nsecs
        key: Any
        if not raw:
            cls = type(msg)
            encode = self._encoders.get(cls)
            if encode is None:
                encode = self._encoders[cls] = find_encoder(cls)
            type_name, data, md5sum, key = cls._type, encode(msg), cls._md5sum, (topic, cls)
            if type_name == "*":
                connection_header = connection_header or getattr(msg, "_connection_header", None)
                if not connection_header:
                    raise ValueError("msg is an AnyMsg that was not received: its type is not known")
                type_name, md5sum = connection_header["type"], connection_header["md5sum"]
                key = (topic, type_name, md5sum)
        elif len(msg) in (4, 5):
            type_name, data, md5sum = msg[:3]
            cls, key = msg[-1], (topic, type_name, md5sum)
        else:
            raise ValueError("msg must be of length 4 or 5")
        self._operations.run(
            self._write_serialized, key, (topic, type_name, md5sum, cls, connection_header), nanoseconds, data
        )

    def _write_serialized(self, key: Any, description: tuple[Any, ...], nanoseconds: int, data: bytes) -> None:
        if not self._file or self._writer is None:
            raise ValueError(CLOSED_BAG_MESSAGE)
        conn = self._topic_connections.get(key)
        if conn is None:
            conn = self._topic_connections[key] = self._get_connection(*description)
        try:
            self._writer.write(conn, nanoseconds, data)
        except BagError as error:
            raise ROSBagFormatException(str(error)) from error

    def _get_connection(self, topic: str, type_name: str, md5sum: str, cls: Any, header: Any) -> int:
        """Return the id of the connection for a topic and type. A new connection gets ``header`` or, if that is None, a
        header with the type's definition.
        """
        key = (topic, type_name, md5sum)
        conn = self._topic_connections.get(key)
        if conn is None:
            if header is None:
                header = header_fields(topic, type_name, md5sum, cls)
            fields = {
                name: value.encode() if isinstance(value, str) else bytes(value) for name, value in header.items()
            }
            _ConnectionInfo(0, topic, fields)  # raises an error if a field is missing
            assert self._writer is not None
            conn = self._topic_connections[key] = self._writer.add_connection(topic, fields)
        return conn

    def flush(self) -> None:
        """Write the open chunk to the file; raise ValueError if the bag is closed."""
        if not self._file:
            raise ValueError(CLOSED_BAG_MESSAGE)
        if self._writer is not None:
            self._operations.run(self._writer.flush)

    def set_encryptor(self, encryptor: str | None = None, param: str | None = None) -> None:
        """Encrypt the bag; must be called before the first message is written.

        Args:
            encryptor: ``rosbag/AesCbcEncryptor``; None or ``rosbag/NoEncryptor`` for a plain bag.
            param: the gpg user whose key is used, or ``*``.

        Raises:
            ROSBagException: the encryptor is unknown, or a message was already written.
            ROSBagEncryptException: the key is not available.
        """
        if encryptor not in (None, *ENCRYPTORS):
            raise ROSBagEncryptNotSupportedException(f"pyros1 has no encryptor {encryptor}")
        if self._mode != "w" or encryptor in (None, NO_ENCRYPTOR) or not self._file:
            return
        assert self._writer is not None
        if self._writer.connections:
            raise ROSBagException("pyros1 sets an encryptor only before the first message is written")
        with stock_errors():
            cipher = new_cipher(param or "*")
        self._writer.abort()
        self._writer = BagWriter(self._target, self._compression, self._chunk_threshold, cipher)
