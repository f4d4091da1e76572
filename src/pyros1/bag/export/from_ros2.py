"""Converts ROS 2 bags, and MCAP files with ROS 2 messages, to ROS 1 bags, using the rosbags library."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection as Ros2Connection
from rosbags.interfaces import ConnectionExtRosbag2
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from pyros1.bag.errors import BagError
from pyros1.bag.export.import_result import ImportResult
from pyros1.bag.export.rosbags_types import (
    Converter,
    copy_types,
    empty_store,
    make_converter,
    make_special_converter,
    parse_types,
    used_types,
)
from pyros1.bag.format.records import RECORD_OVERHEAD
from pyros1.bag.format.writer import BagWriter
from pyros1.ground.errors import MessageError, UnknownTypeError
from pyros1.msgs import from_definition, load_message
from pyros1.ros2_types.mapping import MOVED_MESSAGES, MOVED_TO_ROS1

_TRANSIENT_LOCAL = 1


def import_ros2(
    path: Path,
    target: str | os.PathLike[str],
    *,
    compression: str,
    is_selected: Callable[[str], bool],
    progress: Callable[[int], object] | None,
) -> ImportResult:
    """Convert a ROS 2 bag; arguments and errors as for :func:`pyros1.bag.export.imports.import_bag`."""
    try:
        with (
            AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader,
            BagWriter(target, compression) as writer,
        ):
            return _Importer(reader, writer).run(is_selected, progress)
    except (BagError, OSError):
        raise
    except AnyReaderError as error:
        reason = " ".join(str(error).split())  # YAML's errors have several lines
        raise BagError(str(path), f"rosbags cannot read it: {reason}") from error
    except MemoryError as error:
        raise BagError(str(path), "it claims to hold more data than fits into memory") from error
    except Exception as error:  # rosbags does not catch the errors of SQLite, zstd, lz4, struct and dict
        raise BagError(str(path), f"rosbags cannot read it: {type(error).__name__}: {error}") from error


class _Importer:
    def __init__(self, reader: AnyReader, writer: BagWriter) -> None:
        self._reader = reader
        self._writer = writer
        self._types = _Ros1Types(reader.typestore)

    def run(self, is_selected: Callable[[str], bool], progress: Callable[[int], object] | None) -> ImportResult:
        result = ImportResult()
        target_by_connection: dict[int, tuple[int, Converter]] = {}
        selected_connections = []
        for connection in self._reader.connections:
            if not is_selected(connection.topic):
                continue
            try:
                target_by_connection[connection.id] = self._add_connection(connection)
            except _NotInRos1 as error:
                result.skipped[connection.topic] = str(error)
                continue
            selected_connections.append(connection)
        result.topics = len({connection.topic for connection in selected_connections})
        bytes_done = 0
        for connection, time, data in self._reader.messages(selected_connections) if selected_connections else ():
            conn_id, convert = target_by_connection[connection.id]
            try:
                ros1_data = convert(data)
            except Exception as error:  # as in import_ros2, rosbags raises errors of many types
                message_label = f"message on {connection.topic} at {time / 1e9:.6f} ({connection.msgtype})"
                raise BagError(str(self._reader.paths[0]), f"{message_label} cannot be converted: {error}") from error
            self._writer.write(conn_id, time, ros1_data)
            result.messages += 1
            bytes_done += len(data) + RECORD_OVERHEAD
            if progress is not None:
                progress(bytes_done)
        return result

    def _add_connection(self, connection: Ros2Connection) -> tuple[int, Converter]:
        ros1_type = self._types.get(connection.msgtype)
        profiles = connection.ext.offered_qos_profiles if isinstance(connection.ext, ConnectionExtRosbag2) else []
        latched = any(profile.durability.value == _TRANSIENT_LOCAL for profile in profiles)
        header = {
            "type": ros1_type.name,
            "md5sum": ros1_type.md5sum,
            "message_definition": ros1_type.definition,
            **({"latching": "1"} if latched else {}),
        }
        fields = {name: text.encode("utf-8", "surrogateescape") for name, text in header.items()}
        return self._writer.add_connection(connection.topic, fields), ros1_type.convert


class _NotInRos1(Exception):
    """The type cannot be represented in ROS 1."""


@dataclass(frozen=True)
class _Ros1Type:
    name: str
    md5sum: str
    definition: str
    convert: Converter


class _Ros1Types:
    """The ROS 1 types that correspond to the source's ROS 2 types."""

    def __init__(self, source: Typestore) -> None:
        self._source = source
        self._target = empty_store()
        self._types: dict[str, _Ros1Type] = {}

    def get(self, name: str) -> _Ros1Type:
        """Return the ROS 1 type for a ROS 2 type; raises _NotInRos1 if ROS 1 cannot represent it.

        Args:
            name: ``package/msg/Type``.
        """
        if name not in self._types:
            self._types[name] = self._convert_type(name)
        return self._types[name]

    def _convert_type(self, name: str) -> _Ros1Type:
        package, _, folder_and_name = name.partition("/")
        folder, _, short_name = folder_and_name.partition("/")
        if folder != "msg" or not short_name:
            raise _NotInRos1(f"{name} is not a message type")
        if name not in self._source.fielddefs:
            raise _NotInRos1(f"the definition of {name} is missing")
        ros1_name = MOVED_TO_ROS1.get(name, f"{package}/{short_name}")
        if ros1_name in MOVED_MESSAGES:
            cls = load_message(ros1_name)
            special = make_special_converter(ros1_name, cls._full_text, name, to_ros2=False)
            if special is not None:
                return _Ros1Type(ros1_name, cls._md5sum, cls._full_text, special)
        installed = self._register_installed(name)
        copy_types(self._target, self._source, name)
        convert = make_converter(self._source, self._target, name, name, to_ros2=False)
        if installed is not None:
            return _Ros1Type(ros1_name, *installed, convert)
        definition, _ = self._target.generate_msgdef(name, ros_version=1)
        try:
            return _Ros1Type(ros1_name, from_definition(ros1_name, definition)._md5sum, definition, convert)
        except MessageError as error:
            raise _NotInRos1(f"{name} cannot be defined in ROS 1: {error}") from None

    def _register_installed(self, name: str, visited: Collection[str] = ()) -> tuple[str, str] | None:
        """Register the installed ROS 1 definitions of a type and of the types it uses; return its md5 sum and
        definition, or None if it is not installed.
        """
        if name in visited or name not in self._source.fielddefs:
            return None
        package, _, short_name = name.split("/")
        try:
            cls = load_message(f"{package}/{short_name}")
        except UnknownTypeError:
            for used_type in used_types(self._source, name):
                self._register_installed(used_type, {*visited, name})
            return None
        installed_store = empty_store()
        installed_store.register(parse_types(cls._type, cls._full_text))
        copy_types(self._target, installed_store, name)
        return cls._md5sum, cls._full_text
