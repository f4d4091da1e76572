"""An open bag file, as all readers use it: its version, its header, and single records by offset."""

from __future__ import annotations

import os
import stat
import struct
import threading
from collections.abc import ItemsView, Iterable, Iterator, KeysView, Mapping
from dataclasses import dataclass, field
from io import FileIO
from typing import IO, Any

from pyros1.bag.errors import BagError, EncryptedError, NotABagError
from pyros1.bag.format.encryption import NO_ENCRYPTOR, Cipher, KeyUnavailableError, open_cipher
from pyros1.bag.format.records import (
    BAG_HEADER_SIZE,
    FIRST_LINE_PATTERN,
    MAX_CONNECTIONS,
    MAX_HEADER_SIZE,
    OP_BAG,
    OP_CHUNK,
    OP_CONNECTION,
    U32,
    Connection,
    Fields,
    RecordError,
    op_of,
    parse_connection,
    parse_fields,
    u32_field,
    u64_field,
)
from pyros1.bag.limits import chunk_limit

_CONN_AND_COUNT = struct.Struct("<II")

_HEADER_READ_SIZE = 512
"""Number of bytes that are read first for a record's header; enough for most headers."""

TRUSTED_SIZE = 64 << 20
"""Size in bytes above which a chunk's two lengths are compared, since a damaged length must not exhaust memory."""


class Counts(Mapping[int, int]):
    """Connection id -> number of messages, packed as in the file, since bags with many topics have many entries."""

    __slots__ = ("_packed",)

    def __init__(self, packed: bytes) -> None:
        self._packed = packed

    def __getitem__(self, conn: int) -> int:
        return self.unpacked()[conn]

    def __iter__(self) -> Iterator[int]:
        return iter(self.unpacked())

    def __len__(self) -> int:
        return len(self._packed) // _CONN_AND_COUNT.size

    def keys(self) -> KeysView[int]:
        """Return the connection ids."""
        return self.unpacked().keys()

    def items(self) -> ItemsView[int, int]:
        """Return pairs of connection id and number of messages."""
        return self.unpacked().items()

    def unpacked(self) -> dict[int, int]:
        """Return the counts as a dictionary, for repeated access."""
        return dict(_CONN_AND_COUNT.iter_unpack(self._packed))


@dataclass(slots=True)
class Chunk:
    """A chunk: messages that are stored together.

    Attributes:
        pos: offset of its record in the file; for messages outside of chunks, offset of the first message.
        start: earliest time in it, in nanoseconds.
        end: latest time in it, in nanoseconds.
        counts: connection id -> number of messages.
        loose_size: size in bytes of a run of messages outside of chunks; 0 for a chunk.
        is_complete: whether the chunk is complete; if not, only part of it can be read.
    """

    pos: int
    start: int
    end: int
    counts: Mapping[int, int] = field(default_factory=dict)
    loose_size: int = 0
    is_complete: bool = True


@dataclass(frozen=True)
class ChunkHeader:
    """Header of a chunk.

    Attributes:
        compression: name of the compression.
        size: size of the content in bytes.
        data_offset: offset of the stored bytes in the file.
        stored_size: number of stored bytes, from the header.
    """

    compression: str
    size: int
    data_offset: int
    stored_size: int

    def trusted_size(self, limit: int) -> int:
        """Return the number of stored bytes to read: less than `stored_size` if the two lengths contradict each other.

        Args:
            limit: maximum size of the content in bytes.
        """
        size = min(self.size, limit)
        return min(self.stored_size, max(size + size // 32, TRUSTED_SIZE))


def file_label(target: str | os.PathLike[str] | IO[bytes]) -> str:
    """Return a path as a string, or the name of an open file, for messages to the user."""
    if isinstance(target, (str, os.PathLike)):
        return os.fspath(target)
    return str(getattr(target, "name", "<file object>"))


class BagFile:
    """An open bag file.

    Args:
        source: path of the file, or an open binary file, which stays open when this object is closed.
        limit: maximum size in bytes of the content of a chunk, and of a message outside of chunks; None means the limit
            from the environment (`pyros1.bag.limits.chunk_limit`).

    Attributes:
        path: path of the file, or the name of an open file, for error messages.
        limit: the limit in bytes.
        size: size of the file in bytes, when it was opened.
        version: 200, or 102 for the old version 1.2.
        header: the fields of the bag header.
        begin: offset of the first record after the bag header.
        cipher: decrypts the bag; None if it is not encrypted, or still locked.
        bytes_read: number of bytes read so far; bytes read twice count twice.

    Raises:
        BagError: the file is not a bag (NotABagError), or its header cannot be read.
        OSError: the file cannot be opened.
    """

    def __init__(self, source: str | os.PathLike[str] | IO[bytes], limit: int | None = None) -> None:
        self.path = file_label(source)
        self.limit = chunk_limit(os.environ) if limit is None else limit
        self.cipher: Cipher | None = None
        self.bytes_read = 0
        self._owns_file = isinstance(source, (str, os.PathLike))
        if self._owns_file and stat.S_ISFIFO(os.stat(self.path).st_mode):
            # Opening it would block forever.
            raise NotABagError(self.path, "this is a pipe; bags can only be read from files")
        file: Any = FileIO(self.path, "rb") if self._owns_file else source
        self._file = file
        self._lock = threading.RLock()  # guards the file position: threads may read one bag concurrently
        try:
            self.size: int = file.seek(0, os.SEEK_END)
            self.version, offset = self._read_version()
            self.header, self.begin = self._read_bag_header(offset)
        except BaseException:
            self.close()
            raise

    @property
    def index_pos(self) -> int:
        """Offset of the end section; 0 if the bag was not closed, or its header does not contain the offset."""
        try:
            return u64_field(self.header, "index_pos")
        except RecordError:
            return 0  # treated as a bag without an index: everything else can be read

    @property
    def encryptor_name(self) -> str:
        """Name of the encryptor; empty if the bag is not encrypted."""
        name = self.header.get("encryptor", b"").decode("latin-1")
        return "" if name == NO_ENCRYPTOR else name

    def unlock(self) -> None:
        """Have gpg decrypt the bag's key, if the bag is encrypted.

        Raises:
            EncryptedError: the key cannot be decrypted.
        """
        if not self.encryptor_name or self.cipher is not None:
            return
        try:
            self.cipher = open_cipher(self.header)
        except KeyUnavailableError as error:
            raise EncryptedError(self.path, f"the bag is encrypted and cannot be decrypted: {error}") from None

    def decrypt(self, data: bytes, *, partial: bool = False) -> bytes:
        """Return bytes of an unlocked bag, decrypted if the bag is encrypted.

        Args:
            partial: whether the bytes may be cut off; if so, the part that can be decrypted is returned.

        Raises:
            RecordError: the bytes are damaged.
        """
        return data if self.cipher is None else self.cipher.decrypt(data, partial=partial)

    def close(self) -> None:
        """Close the file, unless it was passed as an open file."""
        if self._owns_file:
            self._file.close()

    def read(self, position: int, size: int) -> bytes:
        """Return `size` bytes from an offset; fewer at the end of the file."""
        size_left = min(size, self.size - position)
        if size_left <= 0:
            return b""  # offsets beyond the end come from damaged records, and may be too large for seek
        parts: list[bytes] = []
        with self._lock:
            self._file.seek(position)
            while size_left > 0:
                part = self._file.read(size_left)
                if not part:
                    break
                parts.append(part)
                size_left -= len(part)
                self.bytes_read += len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def prefetch(self, positions: Iterable[int]) -> None:
        """Ask the system to fetch the records at these offsets in parallel, before they are read one by one."""
        if self._owns_file and hasattr(os, "posix_fadvise"):
            descriptor = self._file.fileno()
            # So that the system does not fetch the bytes around the records.
            os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_RANDOM)
            for position in positions:
                if position < self.size:
                    os.posix_fadvise(descriptor, position, _HEADER_READ_SIZE, os.POSIX_FADV_WILLNEED)
            os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_NORMAL)

    def record(self, position: int) -> tuple[Fields, int, int]:
        """Return the record at an offset: its fields, the offset of its data, and the length that it gives for the
        data, which may be wrong.

        Raises:
            RecordError: there is no record at the offset, or its header is cut off.
        """
        data = self.read(position, _HEADER_READ_SIZE)
        if len(data) < 8:
            raise RecordError("the record is cut off")
        (size,) = U32.unpack_from(data)
        if size > MAX_HEADER_SIZE:
            raise RecordError(f"there is no record here: its header would have {size} bytes")
        if position + 8 + size > self.size:
            raise RecordError("the record's header runs past the end of the file")
        if len(data) < size + 8:
            data = self.read(position, size + 8)
            if len(data) < size + 8:
                raise RecordError("the file was truncated while it was being read")
        fields = parse_fields(data[4 : 4 + size])
        op_of(fields)
        (length,) = U32.unpack_from(data, 4 + size)
        return fields, position + 8 + size, length

    def chunk_header(self, position: int) -> ChunkHeader:
        """Return the header of the chunk at an offset.

        Raises:
            RecordError: there is no chunk at the offset.
        """
        fields, data, length = self.record(position)
        if op_of(fields) != OP_CHUNK:
            raise RecordError("there is no chunk here")
        return ChunkHeader(fields.get("compression", b"").decode("latin-1"), u32_field(fields, "size"), data, length)

    def connection(self, position: int) -> tuple[Connection, int]:
        """Return the connection whose record is at an offset outside of chunks, and the offset after it.

        Raises:
            RecordError: there is no connection at the offset, or it is damaged.
        """
        header, position = self._read_block(position)
        fields = parse_fields(header)
        if op_of(fields) != OP_CONNECTION:
            raise RecordError("this is not the expected kind of record")
        data, position = self._read_block(position)
        return parse_connection(fields, data), position

    def end_connections(self) -> Iterator[tuple[Connection, int]]:
        """Yield the connections of the end section, each with the offset after its record.

        Raises:
            RecordError: a connection is damaged, or there are too many.
        """
        position, count = self.index_pos, u32_field(self.header, "conn_count")
        if count > MAX_CONNECTIONS:
            raise RecordError(f"the number of connections, {count}, is too large")
        for _ in range(count):
            connection, position = self.connection(position)
            yield connection, position

    def _read_block(self, position: int) -> tuple[bytes, int]:
        """Return the decrypted bytes of a block that is preceded by its length, and the offset after the block."""
        packed_size = self.read(position, U32.size)
        size = U32.unpack(packed_size)[0] if len(packed_size) == U32.size else 0
        start = position + U32.size
        if len(packed_size) < U32.size or start + size > self.size:
            raise RecordError("the record is cut off")
        if size > MAX_HEADER_SIZE:
            raise RecordError(f"the record's length, {size} bytes, is too large")
        return self.decrypt(self.read(start, size)), start + size

    def _read_version(self) -> tuple[int, int]:
        """Return the version from the first line, and the offset after that line."""
        if self.size == 0:
            raise NotABagError(self.path, "the file is empty: nothing was recorded")
        line = self.read(0, 64)
        match = FIRST_LINE_PATTERN.match(line)
        if match is not None:
            major, minor = map(int, match.groups())
            if (major, minor) in ((2, 0), (1, 2)):
                return 100 * major + minor, match.end()
            raise NotABagError(self.path, f"bag version {major}.{minor} is not supported; only 2.0 and 1.2 are")
        if len(line) == self.size and line.startswith(b"#ROS"):
            raise NotABagError(self.path, "the file ends in its first line; nothing can be recovered")
        raise NotABagError(self.path, f"this is not a bag file{_describe_format(line)}")

    def _read_bag_header(self, begin: int) -> tuple[Fields, int]:
        try:
            fields, data, length = self.record(begin)
            if op_of(fields) == OP_BAG:
                return fields, self._first_record_offset(data, data + length)
        except RecordError as error:
            if self.version == 200 and self.size <= begin + BAG_HEADER_SIZE:
                raise BagError(
                    self.path, f"the bag header cannot be read ({error}); nothing can be recovered", begin
                ) from None
        return {}, begin  # chunks may follow a damaged header; bags of version 1.2 may have no header

    def _first_record_offset(self, begin: int, end: int) -> int:
        """Return the offset of the first record: `end`, or `begin` if the length of the padding is damaged, so that
        the first record must be searched for from there on.
        """
        try:
            self.record(end)
        except RecordError:
            return end if end == self.size else begin
        return end


_OTHER_FORMATS = {
    b"SQLite format 3": "it is an SQLite database: a ROS 2 bag",
    b"\x89MCAP": "it is an MCAP file; `pyros1 bag import` converts it to a bag",
    b"\x1f\x8b": "it is compressed with gzip; unpack it first",
    b"BZh": "it is compressed with bzip2; unpack it first",
    b"PK\x03\x04": "it is a zip archive; unpack it first",
    b"\xfd7zXZ": "it is compressed with xz; unpack it first",
    b"version https://git-lfs": "it is a Git LFS pointer; `git lfs pull` fetches the file itself",
}


def _describe_format(line: bytes) -> str:
    for signature, description in _OTHER_FORMATS.items():
        if line.startswith(signature):
            return f": {description}"
    if not line.strip(b"\0"):
        return ": it begins with zeros; its content was never written to disk, or was lost"
    return ""
