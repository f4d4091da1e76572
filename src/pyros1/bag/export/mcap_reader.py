"""Reads MCAP files (https://mcap.dev/spec) from beginning to end; needs no index."""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Iterator
from importlib import import_module
from types import TracebackType
from typing import Any

from pyros1.bag.errors import BagError, NotABagError
from pyros1.bag.export.mcap import (
    MAGIC,
    MESSAGE_HEADER,
    OP_CHANNEL,
    OP_CHUNK,
    OP_CHUNK_INDEX,
    OP_DATA_END,
    OP_FOOTER,
    OP_HEADER,
    OP_MESSAGE,
    OP_MESSAGE_INDEX,
    OP_SCHEMA,
    RECORD_HEADER,
    Channel,
    ChunkIndex,
    Cursor,
    Schema,
    check_index,
    iter_records,
    make_chunk_index,
    parse_channel,
    parse_chunk_index,
    parse_schema,
)
from pyros1.bag.format.compression import check_size
from pyros1.bag.format.records import U32, U64, RecordError
from pyros1.bag.limits import chunk_limit

_PIECE_SIZE = 1 << 20
"""Maximum number of bytes that are decompressed at a time."""
_RECOVERY_HINT = "; `mcap recover` of the MCAP tools recovers the intact part"

McapMessage = tuple[Channel, int, memoryview]
"""A message: (channel, time of recording in nanoseconds, bytes)."""


class McapReader:
    """An MCAP file open for reading.

    Args:
        path: path of the file.

    Attributes:
        profile: name of the profile, for example ``ros1``; can be empty.
        schemas: types found so far, by id.
        channels: channels found so far, by id.
        position: number of bytes read so far.

    Raises:
        NotABagError: the file is not an MCAP file.
        BagError: the file is cut off or damaged.
        OSError: the file cannot be opened.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.position = 0
        self._limit = chunk_limit(os.environ)
        self._file = open(self.path, "rb")  # noqa: SIM115 - closed by close()
        try:
            self._size = os.fstat(self._file.fileno()).st_size
            self.profile = self._read_header()
        except BaseException:
            self.close()
            raise

    def messages(self) -> Iterator[McapMessage]:
        """Yield the messages in file order. A message's bytes are valid until the next message is read.

        Raises:
            BagError: the file is cut off or damaged, or its compression is not supported.
        """
        while True:
            offset = self.position
            op, content = self._next_record()
            if op in (OP_DATA_END, OP_FOOTER):
                return
            try:
                if op == OP_CHUNK:
                    for inner_op, inner_content in iter_records(self._decompressed_chunk(content)):
                        if inner_op == OP_CHUNK:
                            raise RecordError("a chunk contains another chunk")
                        message = self._add_record(inner_op, inner_content)
                        if message is not None:
                            yield message
                    continue
                message = self._add_record(op, content)
            except RecordError as error:
                raise BagError(self.path, f"{error}{_RECOVERY_HINT}", offset) from None
            if message is not None:
                yield message

    def check(self) -> None:
        """Read all chunks, and compare the index with them, since other readers trust the index.

        Raises:
            BagError: as for `messages`; or the index does not match the chunks, or too many chunks overlap in time.
        """
        chunks: dict[int, ChunkIndex] = {}
        index: list[ChunkIndex] = []
        summary_starts: set[int] = set()  # offsets at which the summary may start
        while True:
            offset = self.position
            op, content = self._next_record()
            try:
                if op == OP_FOOTER:
                    summary_start = Cursor(content).read_number(U64)
                    if self.position + len(MAGIC) != self._size or (
                        summary_start and summary_start not in summary_starts | {offset}
                    ):
                        raise RecordError("the index is not where the footer says")
                    check_index(index, chunks, self._limit)
                    return
                if op in (OP_CHUNK, OP_MESSAGE, OP_MESSAGE_INDEX):
                    summary_starts.clear()
                else:
                    summary_starts.add(offset)
                if op == OP_CHUNK:
                    chunks[offset] = make_chunk_index(content, offset, len(self._decompressed_chunk(content)))
                elif op == OP_CHUNK_INDEX:
                    index.append(parse_chunk_index(content))
            except RecordError as error:
                raise BagError(self.path, f"{error}{_RECOVERY_HINT}", offset) from None

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> McapReader:
        return self

    def __exit__(
        self, error_type: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _read_header(self) -> str:
        if self._size == 0:
            raise NotABagError(self.path, "the file is empty")
        magic = self._file.read(len(MAGIC))
        if magic != MAGIC:
            raise NotABagError(self.path, "this is not an MCAP file: it does not begin with the MCAP signature")
        self.position = len(MAGIC)
        op, content = self._next_record()
        try:
            if op != OP_HEADER:
                raise RecordError("the file has no header")
            return Cursor(content).read_string()
        except RecordError as error:
            raise BagError(self.path, str(error), len(MAGIC)) from None

    def _next_record(self) -> tuple[int, memoryview]:
        """Return the op and content of the next record; the content is empty if no caller needs it."""
        offset = self.position
        header = self._file.read(RECORD_HEADER.size)
        if len(header) < RECORD_HEADER.size:
            raise BagError(self.path, f"the file is cut off{_RECOVERY_HINT}", offset)
        op, size = RECORD_HEADER.unpack(header)
        next_position = offset + RECORD_HEADER.size + size
        if op == 0 or next_position > self._size:
            problem = "this is not a record" if op == 0 else "the record runs past the end of the file"
            raise BagError(self.path, f"{problem}: the file is cut off or damaged{_RECOVERY_HINT}", offset)
        self.position = next_position
        if op not in (OP_HEADER, OP_SCHEMA, OP_CHANNEL, OP_MESSAGE, OP_CHUNK, OP_CHUNK_INDEX, OP_FOOTER):
            self._file.seek(next_position)  # skips, for example, an attachment, which may be large
            return op, memoryview(b"")
        try:
            check_size(size, self._limit)
        except RecordError as error:
            raise BagError(self.path, str(error), offset) from None
        content = self._file.read(size)
        if len(content) < size:
            raise BagError(self.path, f"the file was truncated while it was being read{_RECOVERY_HINT}", offset)
        return op, memoryview(content)

    def _add_record(self, op: int, content: memoryview) -> McapMessage | None:
        if op == OP_MESSAGE:
            if len(content) < MESSAGE_HEADER.size:
                raise RecordError("a message's record is too short")
            channel_id, _, time, _ = MESSAGE_HEADER.unpack_from(content)
            channel = self.channels.get(channel_id)
            if channel is None:
                raise RecordError(f"a message refers to channel {channel_id}, which is not defined before it")
            return channel, time, content[MESSAGE_HEADER.size :]
        if op == OP_SCHEMA:
            schema = parse_schema(content)
            if self.schemas.setdefault(schema.id, schema) != schema:
                raise RecordError(f"type {schema.id} is defined twice, with different contents")
        elif op == OP_CHANNEL:
            channel = parse_channel(content)
            if self.channels.setdefault(channel.id, channel) != channel:
                raise RecordError(f"channel {channel.id} is defined twice, with different contents")
        return None

    def _decompressed_chunk(self, content: memoryview) -> memoryview:
        """Return the uncompressed content of a chunk; raises RecordError if it is damaged."""
        cursor = Cursor(content)
        cursor.read_bytes(16)  # the times of its first and last message
        size, checksum = cursor.read_number(U64), cursor.read_number(U32)
        compression = cursor.read_string()
        stored = cursor.read_bytes(cursor.read_number(U64))
        check_size(size, self._limit)
        content_bytes = stored if not compression else memoryview(self._decompress(compression, stored, size))
        if len(content_bytes) != size:
            raise RecordError(f"the chunk does not hold the {size} bytes that its header claims")
        if checksum and zlib.crc32(content_bytes) != checksum:
            raise RecordError("the chunk is damaged: its checksum is wrong")
        return content_bytes

    def _decompress(self, compression: str, stored: memoryview, size: int) -> bytes:
        """Return the content, up to ``size + 1`` bytes, so that a damaged chunk cannot exhaust memory."""
        make_decompressor = self._choose_decompressor(compression)
        data: Any = stored
        parts: list[bytes] = []
        total = 0
        try:
            decompressor = make_decompressor()
            while total <= size:
                # In pieces: some decompressors allocate in advance as much as they may return.
                parts.append(decompressor.decompress(data, min(size + 1 - total, _PIECE_SIZE)))
                total += len(parts[-1])
                data = b""
                if decompressor.eof:
                    data = decompressor.unused_data
                    if not data:
                        break
                    decompressor = make_decompressor()  # there may be several frames
                elif not parts[-1]:
                    break  # it is truncated
        except Exception as error:  # each module has its own errors
            raise RecordError(f"the chunk's {compression} data are damaged: {error}") from error
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def _choose_decompressor(self, compression: str) -> Callable[[], Any]:
        if compression == "lz4":
            return _import_first(self.path, compression, "lz4.frame").LZ4FrameDecompressor  # type: ignore[no-any-return]
        if compression == "zstd":
            return _import_first(self.path, compression, "compression.zstd", "backports.zstd").ZstdDecompressor  # type: ignore[no-any-return]
        raise RecordError(f"the chunk's compression {compression[:20]!r} is unknown; lz4 and zstd are supported")


def _import_first(path: str, compression: str, *names: str) -> Any:
    """Import and return the first module that is installed. If none is, raise BagError with the last one's package."""
    for name in names:
        try:
            return import_module(name)
        except ImportError:
            continue
    package = names[-1].removesuffix(".frame")
    raise BagError(path, f"it is compressed with {compression}; to read it: pip install {package}")
