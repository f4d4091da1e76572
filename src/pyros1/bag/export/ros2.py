"""Converts ROS 1 bags to ROS 2 bags and to MCAP files with ROS 2 messages, using the rosbags library."""

from __future__ import annotations

import errno
import os
import shutil
import sqlite3
from pathlib import Path
from typing import Literal

from rosbags.convert.converter import LATCH
from rosbags.interfaces import Connection as Ros2Connection
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_typestore

from pyros1.bag.errors import BagError
from pyros1.bag.export.rosbags_types import (
    Converter,
    copy_types,
    empty_store,
    make_converter,
    make_special_converter,
    parse_types,
    ros2_name,
)
from pyros1.bag.format.reader import RawMessage
from pyros1.bag.format.records import Connection
from pyros1.ground.errors import MessageError
from pyros1.msgs import DefinitionCache
from pyros1.ros2_types.legal_names import LegalNames

STORAGE_PLUGINS = {"sqlite3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}
"""Name of a storage format for ROS 2 bags -> rosbags' plugin for it."""

_METADATA_VERSION: Literal[8] = 8
"""Version of the metadata file. ROS 2 distributions before Jazzy cannot read newer versions."""


class Ros2Writer:
    """A new ROS 2 bag: a folder with a metadata file and a message file.

    Types that the ROS 2 distribution knows get the distribution's definitions; other types keep the bag's definitions,
    under names that ROS 2 allows.

    Args:
        path: the folder, which must not exist.
        storage: ``sqlite3`` or ``mcap``.
        distribution: name of a ROS 2 distribution, for example ``jazzy``.

    Attributes:
        names: the mapping of type and field names to ROS 2's.

    Raises:
        OSError: the folder cannot be created.
    """

    def __init__(self, path: str | os.PathLike[str], storage: str = "sqlite3", distribution: str = "jazzy") -> None:
        self.path = Path(path)
        self._typestore = get_typestore(Stores(f"ros2_{distribution}"))
        self.names = LegalNames(frozenset(self._typestore.fielddefs))
        self._classes = DefinitionCache()
        self._converters: dict[tuple[str, str], Converter] = {}
        self._connections: dict[int, tuple[Ros2Connection, Converter]] = {}
        self._ros2_connections: dict[tuple[str, str, bool], Ros2Connection] = {}
        self._sources: list[Connection] = []  # keeps the connections alive, so that their id() values are not reused
        self._writer = Writer(self.path, version=_METADATA_VERSION, storage_plugin=STORAGE_PLUGINS[storage])
        self._writer.open()

    def write_raw(self, stored: RawMessage) -> None:
        """Write a message.

        Raises:
            BagError: the definition cannot be read, or the message cannot be converted; the error names the message.
            OSError: the file cannot be written.
        """
        connection = stored.connection
        entry = self._connections.get(id(connection))
        try:
            if entry is None:
                entry = self._connections[id(connection)] = self._add_connection(connection)
                self._sources.append(connection)
            self._writer.write(entry[0], stored.time, self._convert(entry[1], stored))
        except (TypesysError, SerdeError, WriterError, MessageError, KeyError, UnicodeDecodeError) as error:
            message_label = f"message on {connection.topic} at {stored.time / 1e9:.6f} ({connection.type})"
            raise BagError(str(self.path), f"{message_label} cannot be converted: {error}") from error
        except sqlite3.Error as error:  # SQLite's errors for a full disk and similar problems
            raise OSError(errno.EIO, str(error), str(self.path)) from error

    def close(self) -> None:
        """Write the remaining data and the metadata.

        Raises:
            OSError: the file cannot be written.
        """
        try:
            self._writer.close()
        except sqlite3.Error as error:
            raise OSError(errno.EIO, str(error), str(self.path)) from error

    def abort(self) -> None:
        """Close the files in their current state."""
        self._writer.abort()

    def _add_connection(self, connection: Connection) -> tuple[Ros2Connection, Converter]:
        convert = self._converter_for(connection)
        name = self.names.legal_type(ros2_name(connection.type))
        key = (connection.topic, name, connection.latching)
        ros2_connection = self._ros2_connections.get(key)
        if ros2_connection is None:
            ros2_connection = self._ros2_connections[key] = self._writer.add_connection(
                connection.topic,
                name,
                typestore=self._typestore,
                offered_qos_profiles=LATCH if connection.latching else [],
            )
        return ros2_connection, convert

    def _convert(self, convert: Converter, stored: RawMessage) -> memoryview:
        try:
            return convert(stored.data)
        except SerdeError:
            # The message may have extra bytes at the end, which are harmless.
            connection, data = stored.connection, stored.data
            try:
                cls = self._classes.get(connection.type, connection.md5sum, connection.definition)
                data = cls._encode(cls._decode(data, 0, len(data)))
            except MessageError:
                pass
            if data == stored.data:
                raise
            return convert(data)

    def _converter_for(self, connection: Connection) -> Converter:
        key = (connection.type, connection.md5sum)
        if key not in self._converters:
            self._converters[key] = self._make_converter(connection)
        return self._converters[key]

    def _make_converter(self, connection: Connection) -> Converter:
        name = self.names.legal_type(ros2_name(connection.type))
        special = make_special_converter(connection.type, connection.definition, name, to_ros2=True)
        if special is not None:
            return special
        source = empty_store()
        source.register(self.names.legal_types(parse_types(connection.type, connection.definition)))
        copy_types(self._typestore, source, name)
        return make_converter(source, self._typestore, name, name, to_ros2=True)


class Ros2McapWriter(Ros2Writer):
    """A new MCAP file with ROS 2 messages.

    Args:
        path: the file, replaced if it exists; its folder must be writable.
        distribution: name of a ROS 2 distribution, for example ``jazzy``.
    """

    def __init__(self, path: str | os.PathLike[str], distribution: str = "jazzy") -> None:
        self._file = Path(path)
        super().__init__(self._file.with_name(f"{self._file.name}.parts"), "mcap", distribution)

    def close(self) -> None:
        """Write the remaining data."""
        super().close()
        (mcap_file,) = self.path.glob("*.mcap")
        os.replace(mcap_file, self._file)
        shutil.rmtree(self.path)
