"""Converts MCAP files with ROS 1 messages, from the MCAP tools or Foxglove, to bags. Messages are copied unchanged."""

from __future__ import annotations

import os
import re
from collections.abc import Callable

from pyros1.bag.errors import BagError
from pyros1.bag.export.import_result import ImportResult
from pyros1.bag.export.mcap import ROS1_ENCODING, ROS1_SCHEMA, Channel
from pyros1.bag.export.mcap_reader import McapReader
from pyros1.bag.format.writer import BagWriter
from pyros1.ground.errors import MessageError
from pyros1.msgs import DefinitionCache
from pyros1.msgs.spec import is_type_name

_MD5SUM_PATTERN = re.compile(r"[0-9a-f]{32}|\*")
_FIELD_NAME_PATTERN = re.compile("[!-<>-~]+")
_LATCHING_VALUES = {"true": "1", "false": "0"}
"""Value of ``latching`` in MCAP's ROS 1 profile -> value in connection headers, which some MCAP writers use instead."""
_FIELDS_NOT_FROM_METADATA = ("type", "md5sum", "message_definition")


def import_ros1(
    reader: McapReader,
    target: str | os.PathLike[str],
    *,
    compression: str,
    is_selected: Callable[[str], bool],
    progress: Callable[[int], object] | None,
) -> ImportResult:
    """Convert an MCAP file; arguments and errors as for :func:`pyros1.bag.export.imports.import_bag`."""
    with BagWriter(target, compression) as writer:
        importer = _Importer(reader, writer, is_selected)
        for channel, time, data in reader.messages():
            conn_id = importer.connection_id(channel)
            if conn_id is None:
                continue
            writer.write(conn_id, time, data)
            if progress is not None:
                progress(reader.position)
        for channel in reader.channels.values():
            importer.connection_id(channel)  # adds channels without messages, too
        result = importer.result
        result.messages, result.topics = (
            writer.messages,
            len({connection.topic for connection in writer.connections.values()}),
        )
        if result.skipped and not result.topics:
            topic, reason = next(iter(result.skipped.items()))
            raise BagError(reader.path, f"it has no ROS 1 messages that can be imported: {topic}: {reason}")
    return result


class _Importer:
    def __init__(self, reader: McapReader, writer: BagWriter, is_selected: Callable[[str], bool]) -> None:
        self.result = ImportResult()
        self._reader = reader
        self._writer = writer
        self._is_selected = is_selected
        self._conn_ids: dict[int, int | None] = {}

    def connection_id(self, channel: Channel) -> int | None:
        """Return the connection id for a channel in the bag, adding new connections; None if the channel is skipped."""
        if channel.id not in self._conn_ids:
            self._conn_ids[channel.id] = self._add_connection(channel) if self._is_selected(channel.topic) else None
        return self._conn_ids[channel.id]

    def _add_connection(self, channel: Channel) -> int | None:
        try:
            header = self._connection_header(channel)
        except _NotRos1 as error:
            self.result.skipped[channel.topic] = str(error)
            return None
        return self._writer.add_connection(channel.topic, header)

    def _connection_header(self, channel: Channel) -> dict[str, bytes]:
        if channel.encoding != ROS1_ENCODING:
            raise _NotRos1(f"its messages are encoded as {channel.encoding!r}, not {ROS1_ENCODING!r}")
        schema = self._reader.schemas.get(channel.schema_id)
        if schema is None:
            raise _NotRos1("the definition of its type is missing")
        if schema.encoding != ROS1_SCHEMA:
            raise _NotRos1(f"the definition of {schema.name} is encoded as {schema.encoding!r}, not {ROS1_SCHEMA!r}")
        if not is_type_name(schema.name):
            raise _NotRos1(f"{schema.name!r} is not a ROS 1 type name")
        md5sum = channel.metadata.get("md5sum", "")
        if not _MD5SUM_PATTERN.fullmatch(md5sum):
            try:
                text = schema.data.decode("utf-8", "surrogateescape")
                md5sum = DefinitionCache().get(schema.name, "*", text)._md5sum
            except MessageError as error:
                raise _NotRos1(f"the definition of its type is wrong: {error}") from None
        texts = {"type": schema.name, "md5sum": md5sum}
        fields = {name: text.encode("utf-8", "surrogateescape") for name, text in texts.items()}
        fields["message_definition"] = schema.data
        for name, text in channel.metadata.items():
            if name in _FIELDS_NOT_FROM_METADATA or not _FIELD_NAME_PATTERN.fullmatch(name):
                continue
            value = _LATCHING_VALUES.get(text.lower(), text) if name == "latching" else text
            fields[name] = value.encode("utf-8", "surrogateescape")
        return fields


class _NotRos1(Exception):
    """The channel does not contain ROS 1 messages."""
