"""Exceptions and types of `rosbag.bag`: compressions, tuples, and the records of a bag's index."""

from __future__ import annotations

import collections
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from genpy.dynamic import make_importable
from genpy.rostime import Time

from pyros1.bag.errors import BagError, EncryptedError, UnindexedError
from pyros1.bag.format.encryption import KeyUnavailableError
from pyros1.bag.format.files import Chunk, ChunkHeader
from pyros1.bag.format.reader import Entry
from pyros1.bag.format.records import Connection
from pyros1.msgs import DefinitionCache

# Exceptions -----------------------------------------------------------------------------------------------------------


class ROSBagException(Exception):
    """Base class of rosbag's exceptions.

    Attributes:
        value: the message.
    """

    def __init__(self, value: Any = None) -> None:
        super().__init__(value)
        self.value = value

    def __str__(self) -> str:
        return str(self.value)


class ROSBagFormatException(ROSBagException):
    """The file is damaged."""

    def __init__(self, value: Any) -> None:
        super().__init__(value)


class ROSBagUnindexedException(ROSBagException):
    """The bag has no index because it was not closed."""

    def __init__(self, *args: Any) -> None:
        super().__init__("Unindexed bag")


class ROSBagEncryptNotSupportedException(ROSBagException):
    """The bag is encrypted in a way that is not supported."""

    def __init__(self, value: Any) -> None:
        super().__init__(value)


class ROSBagEncryptException(ROSBagException):
    """The bag cannot be encrypted or decrypted."""

    def __init__(self, value: Any) -> None:
        super().__init__(value)


class Compression:
    """Names of the compression methods."""

    NONE = "none"
    BZ2 = "bz2"
    LZ4 = "lz4"


@contextmanager
def stock_errors() -> Iterator[None]:
    """Convert pyros1's exceptions in a ``with`` block to rosbag's."""
    try:
        yield
    except UnindexedError as error:
        raise ROSBagUnindexedException from error
    except (EncryptedError, KeyUnavailableError) as error:
        raise ROSBagEncryptException(str(error)) from error
    except BagError as error:
        raise ROSBagFormatException(str(error)) from error


# Return values --------------------------------------------------------------------------------------------------------

_PUBLIC_MODULE = "rosbag.bag"  # the module name that programs import, print and pickle
BagMessage = collections.namedtuple("BagMessage", "topic message timestamp", module=_PUBLIC_MODULE)
BagMessageWithConnectionHeader = collections.namedtuple(
    "BagMessageWithConnectionHeader", "topic message timestamp connection_header", module=_PUBLIC_MODULE
)
TopicTuple = collections.namedtuple("TopicTuple", "msg_type message_count connections frequency", module=_PUBLIC_MODULE)
TypesAndTopicsTuple = collections.namedtuple("TypesAndTopicsTuple", "msg_types topics", module=_PUBLIC_MODULE)
CompressionTuple = collections.namedtuple(
    "CompressionTuple", "compression uncompressed compressed", module=_PUBLIC_MODULE
)
for _class in (
    Compression,
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
    ROSBagEncryptException,
    ROSBagEncryptNotSupportedException,
):
    _class.__module__ = _PUBLIC_MODULE


# Classes of messages --------------------------------------------------------------------------------------------------

_message_types: dict[str, Any] = {}
_MAX_TYPES = 10_000
_definitions = DefinitionCache()


def _get_message_type(info: Any) -> Any:
    """Return the class of a connection's messages, made from the definition in the bag.

    Classes that a program has added to `_message_types`, by md5 sum, are preferred if they have that type.

    Raises:
        ROSBagException: the definition is invalid.
    """
    cls = _message_types.get(info.md5sum)
    if cls is None or cls._type != info.datatype:
        try:
            cls = _definitions.get(info.datatype, info.md5sum, info.msg_def)
            if cls.__module__ not in sys.modules:
                make_importable({info.datatype: cls})
        except Exception as error:
            raise ROSBagException(f"Error generating datatype {info.datatype}: {error}") from error
        if info.md5sum not in (cls._md5sum, "*"):
            print(
                f"WARNING: For type [{info.datatype}] stored md5sum [{info.md5sum}] does not match message definition "
                f'[{cls._md5sum}].\n  Try: "rosrun rosbag fix_msg_defs.py old_bag new_bag."',
                file=sys.stderr,
            )
        if len(_message_types) < _MAX_TYPES:
            _message_types.setdefault(info.md5sum, cls)
    return cls


# The index ------------------------------------------------------------------------------------------------------------


class _ConnectionInfo:
    """A connection: its number, topic, and header with values as bytes."""

    def __init__(self, id: int, topic: str, header: Any) -> None:
        for name in ("type", "md5sum", "message_definition"):
            if name not in header:
                raise ROSBagFormatException(f'expected "{name}" field in record')
        self.id = id
        self.topic = topic
        self.header = header
        self.datatype = _to_text(header["type"])
        self.md5sum = _to_text(header["md5sum"])
        self.msg_def = _to_text(header["message_definition"])

    def __str__(self) -> str:
        return f"{self.id} on {self.topic}: {self.header!s}"


def _to_text(value: str | bytes) -> str:
    return value if isinstance(value, str) else value.decode("utf-8", "surrogateescape")


def to_connection_info(connection: Connection) -> _ConnectionInfo:
    """Convert a connection to stock's class."""
    return _ConnectionInfo(connection.id, connection.topic, dict(connection.header))


class _IndexEntry200:
    """A message's time, the position of its chunk, and its offset in the chunk."""

    def __init__(self, time: Any, chunk_pos: int, offset: int) -> None:
        self.time = time
        self.chunk_pos = chunk_pos
        self.offset = offset

    @property
    def position(self) -> tuple[int, int]:
        """The position of the message, for ``Bag._read_message``."""
        return self.chunk_pos, self.offset

    def __lt__(self, other: _IndexEntry200) -> bool:
        return bool(self.time < other.time)

    def __str__(self) -> str:
        return f"{self.time.secs}.{self.time.nsecs}: {self.chunk_pos}+{self.offset}"


def to_index_entry(entry: Entry) -> _IndexEntry200:
    """Convert an entry of the index to stock's class."""
    return _IndexEntry200(Time.from_nsec(entry.time), *entry.location)


class _ChunkInfo:
    """A chunk in the index."""

    def __init__(self, pos: int, start_time: Any, end_time: Any) -> None:
        self.pos = pos
        self.start_time = start_time
        self.end_time = end_time
        self.connection_counts: dict[int, int] = {}


def to_chunk_info(chunk: Chunk) -> _ChunkInfo:
    """Convert a chunk to stock's class."""
    info = _ChunkInfo(chunk.pos, Time.from_nsec(chunk.start), Time.from_nsec(chunk.end))
    info.connection_counts = dict(chunk.counts)
    return info


class _ChunkHeader:
    """Header of a chunk: its compression, sizes in bytes, and the position of its data."""

    def __init__(self, compression: str, compressed_size: int, uncompressed_size: int, data_pos: int = 0) -> None:
        self.compression = compression
        self.compressed_size = compressed_size
        self.uncompressed_size = uncompressed_size
        self.data_pos = data_pos


def to_chunk_header(header: ChunkHeader) -> _ChunkHeader:
    """Convert a chunk's header to stock's class."""
    return _ChunkHeader(header.compression, header.stored_size, header.size, header.data_offset)
