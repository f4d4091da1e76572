"""Writes MCAP files (https://mcap.dev/spec) with unchanged ROS 1 messages, in the profile ``ros1``."""

from __future__ import annotations

import os
import struct
import zlib

import pyros1
from pyros1.bag.errors import BagError
from pyros1.bag.export.mcap import (
    MAGIC,
    MESSAGE_HEADER,
    OP_CHANNEL,
    OP_CHUNK,
    OP_CHUNK_INDEX,
    OP_DATA_END,
    OP_FOOTER,
    OP_MESSAGE,
    OP_MESSAGE_INDEX,
    OP_SCHEMA,
    OP_STATISTICS,
    RECORD_HEADER,
    ROS1_ENCODING,
    ROS1_SCHEMA,
    U16,
    Channel,
    Schema,
    pack_channel,
    pack_header,
    pack_map,
    pack_record,
    pack_schema,
    pack_string,
    pack_summary_offset,
)
from pyros1.bag.format.reader import RawMessage
from pyros1.bag.format.records import U32, U64, Connection

CHUNK_THRESHOLD = 1 << 20
"""Size in bytes above which a chunk is written to the file."""

MAX_ID = (1 << 16) - 1
"""Maximum number of channels and types: their ids have 16 bits."""
_PROFILE = "ros1"
_LATCHING_VALUES = {"1": "true", "0": "false"}
_FIELDS_NOT_IN_METADATA = ("type", "message_definition")
_CHUNK_HEADER = struct.Struct("<QQQI")
_ID_AND_NUMBER = struct.Struct("<HQ")
_STATISTICS = struct.Struct("<QHIIIIQQ")
_INDEX_ENTRY = struct.Struct("<QQ")
_CHUNK_LOCATION = struct.Struct("<QQQQ")


class _TimeRange:
    """The earliest and latest of the added times; 0 if there are none."""

    def __init__(self) -> None:
        self.first = self.last = self.count = 0

    def add(self, time: int) -> None:
        self.first = min(self.first, time) if self.count else time
        self.last = max(self.last, time)
        self.count += 1


class Ros1McapWriter:
    """A new MCAP file with messages in ROS 1's encoding.

    Args:
        path: the file; replaced if it exists.

    Raises:
        OSError: the file cannot be created.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)
        self._schemas: dict[tuple[str, bytes], Schema] = {}
        self._channels: dict[tuple[str, tuple[tuple[str, bytes], ...]], Channel] = {}
        self._channel_ids: dict[int, int] = {}
        self._sources: list[Connection] = []  # keeps the connections alive, so that their id() values are not reused
        self._message_counts: dict[int, int] = {}
        self._times = _TimeRange()
        self._chunk_indexes: list[bytes] = []
        self._content = bytearray()
        self._chunk_times = _TimeRange()
        self._index: dict[int, list[tuple[int, int]]] = {}
        self._position = 0
        self._file = open(self.path, "wb")  # noqa: SIM115 - closed by close() and abort()
        self._write(MAGIC + pack_header(_PROFILE, f"pyros1 {pyros1.__version__}"))

    def write_raw(self, stored: RawMessage) -> None:
        """Write a message.

        Raises:
            BagError: there are more connections than an MCAP file can hold.
            OSError: the file cannot be written.
        """
        connection = stored.connection
        channel_id = self._channel_ids.get(id(connection))
        if channel_id is None:
            channel_id = self._channel_ids[id(connection)] = self._add_channel(connection)
            self._sources.append(connection)
        time, sequence, content = stored.time, self._message_counts[channel_id], self._content
        self._index.setdefault(channel_id, []).append((time, len(content)))
        content += RECORD_HEADER.pack(OP_MESSAGE, MESSAGE_HEADER.size + len(stored.data))
        content += MESSAGE_HEADER.pack(channel_id, sequence & 0xFFFFFFFF, time, time)
        content += stored.data
        self._message_counts[channel_id] = sequence + 1
        self._times.add(time)
        self._chunk_times.add(time)
        if len(content) > CHUNK_THRESHOLD:
            self._flush()

    def close(self) -> None:
        """Write the remaining data and the summary.

        Raises:
            OSError: the file cannot be written.
        """
        try:
            self._flush()
            self._write(pack_record(OP_DATA_END, U32.pack(0)))
            self._write(self._encode_summary())
        finally:
            self._file.close()

    def abort(self) -> None:
        """Close the file in its current state."""
        self._file.close()

    def _add_channel(self, connection: Connection) -> int:
        """Return the id of a connection's channel, which identical connections share; raises BagError if there are too
        many.
        """
        definition = connection.header["message_definition"]
        schema_key = (connection.type, definition)
        key = (connection.topic, tuple(connection.header.items()))
        if key in self._channels:
            return self._channels[key].id
        if max(len(self._channels), len(self._schemas)) >= MAX_ID:
            raise BagError(self.path, f"an MCAP file can hold at most {MAX_ID} connections and types")
        if schema_key not in self._schemas:
            schema = Schema(len(self._schemas) + 1, connection.type, ROS1_SCHEMA, definition)
            self._schemas[schema_key] = schema
            self._content += pack_schema(schema)
        metadata = {name: connection.text(name) for name in connection.header if name not in _FIELDS_NOT_IN_METADATA}
        if metadata.get("topic") == connection.topic:
            del metadata["topic"]
        if "latching" in metadata:
            metadata["latching"] = _LATCHING_VALUES.get(metadata["latching"], metadata["latching"])
        channel_id = len(self._channels)
        channel = Channel(channel_id, self._schemas[schema_key].id, connection.topic, ROS1_ENCODING, metadata)
        self._channels[key] = channel
        self._content += pack_channel(channel)
        self._message_counts[channel_id] = 0
        return channel_id

    def _flush(self) -> None:
        """Write the open chunk and its index records."""
        content, index, times = self._content, self._index, self._chunk_times
        if not content:
            return
        self._content, self._index, self._chunk_times = bytearray(), {}, _TimeRange()
        start, size = self._position, len(content)
        fields = (
            _CHUNK_HEADER.pack(times.first, times.last, size, zlib.crc32(content)) + pack_string("") + U64.pack(size)
        )
        self._write(RECORD_HEADER.pack(OP_CHUNK, len(fields) + size) + fields)
        self._write(content)
        end = self._position
        index_offsets = []
        for channel_id, entries in index.items():
            index_offsets.append(_ID_AND_NUMBER.pack(channel_id, self._position))
            packed = pack_map(_INDEX_ENTRY.pack(*entry) for entry in sorted(entries))
            self._write(pack_record(OP_MESSAGE_INDEX, U16.pack(channel_id), packed))
        self._chunk_indexes.append(
            pack_record(
                OP_CHUNK_INDEX,
                _CHUNK_LOCATION.pack(times.first, times.last, start, end - start),
                pack_map(index_offsets),
                U64.pack(self._position - end),
                pack_string(""),
                U64.pack(size) + U64.pack(size),
            )
        )

    def _encode_summary(self) -> bytes:
        """Return the end of the file: the summary and footer."""
        counts = _STATISTICS.pack(
            self._times.count,
            len(self._schemas),
            len(self._channels),
            0,
            0,
            len(self._chunk_indexes),
            self._times.first,
            self._times.last,
        )
        groups = {
            OP_SCHEMA: b"".join(map(pack_schema, self._schemas.values())),
            OP_CHANNEL: b"".join(map(pack_channel, self._channels.values())),
            OP_STATISTICS: pack_record(
                OP_STATISTICS, counts, pack_map(_ID_AND_NUMBER.pack(*item) for item in self._message_counts.items())
            ),
            OP_CHUNK_INDEX: b"".join(self._chunk_indexes),
        }
        summary, offsets = bytearray(), bytearray()
        for op, records in groups.items():
            if records:
                offsets += pack_summary_offset(op, self._position + len(summary), len(records))
                summary += records
        offsets_start = self._position + len(summary)
        footer = RECORD_HEADER.pack(OP_FOOTER, 20) + U64.pack(self._position) + U64.pack(offsets_start)
        summary += offsets + footer
        return bytes(summary) + U32.pack(zlib.crc32(summary)) + MAGIC

    def _write(self, data: bytes | bytearray) -> None:
        self._file.write(data)
        self._position += len(data)
