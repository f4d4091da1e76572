"""Handles message types as the rosbags library represents them, and converts between ROS 1 and ROS 2 messages."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from rosbags.convert.converter import is_same_wireformat, migrate_bytes
from rosbags.interfaces import Nodetype
from rosbags.interfaces.typing import Typesdict
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from pyros1.msgs.digest import split_full_text
from pyros1.msgs.spec import parse_message
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.mapping import MOVED_MESSAGES, STANDARD_FIELDS
from pyros1.ros2_types.transcoding.transcoder import Transcoder

_CONSTANT_PATTERN = re.compile(r"^[ \t]*\w+[ \t]+\w+[ \t]*=.*$", re.MULTILINE)

Converter = Callable[[bytes], memoryview]
"""A function that converts an encoded message."""


def ros2_name(type_name: str) -> str:
    """Return a type's name in ROS 2: ``std_msgs/msg/String`` for ``std_msgs/String``."""
    package, _, name = type_name.partition("/")
    return MOVED_MESSAGES.get(type_name, f"{package}/msg/{name}")


def distributions() -> dict[str, str]:
    """Return the ROS 2 distributions that rosbags knows: name, such as ``jazzy`` -> name of its type store."""
    return {store.value[5:]: store.value for store in Stores if store.value.startswith("ros2_")}


def parse_types(type_name: str, definition: str) -> Typesdict:
    """Parse the types in a full definition.

    Args:
        type_name: ``package/Type``.
        definition: the definition of the type, followed by the definitions of all types that it uses.

    Raises:
        TypesysError: rosbags cannot read the definition.
    """
    text = definition.replace("\r\n", "\n")
    try:
        return get_types_from_msg(text, ros2_name(type_name))
    except TypesysError:
        # rosbags cannot read every constant; without constants the encoding is the same.
        return get_types_from_msg(_CONSTANT_PATTERN.sub("", text), ros2_name(type_name))


def empty_store() -> Typestore:
    """Return a store without message types."""
    return get_typestore(Stores.EMPTY)


def copy_types(target: Typestore, source: Typestore, name: str) -> None:
    """Copy a type and the types that it uses from one store to another, except for types that the target already has.

    Raises:
        KeyError: a type is missing in the source.
    """
    missing_types: Typesdict = {}

    def collect(type_name: str) -> None:
        if type_name not in target.fielddefs and type_name not in missing_types:
            missing_types[type_name] = source.fielddefs[type_name]
            for used_type in used_types(source, type_name):
                collect(used_type)

    collect(name)
    target.register(missing_types)


def used_types(store: Typestore, name: str) -> Iterator[str]:
    """Yield the names of the message types of a type's fields."""
    for _, field_type in store.fielddefs[name][1]:
        element_type: Any = field_type[1][0] if field_type[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE) else field_type
        if element_type[0] == Nodetype.NAME:
            yield str(element_type[1])


def make_converter(source: Typestore, target: Typestore, name: str, target_name: str, *, to_ros2: bool) -> Converter:
    """Return the function that converts messages of a type between ROS 1 and ROS 2.

    If the fields on both sides have the same types in the same order, the bytes are rearranged. Otherwise fields are
    matched by name and type, and fields without a counterpart are zero.

    Args:
        source: the store with `name`.
        target: the store with `target_name`.
        to_ros2: True to convert from ROS 1 to ROS 2, False for the other direction.
    """
    cache: dict[str, object] = {}

    def migrate(data: bytes) -> memoryview:
        return migrate_bytes(source, target, name, target_name, cache, data, src_is2=not to_ros2, dst_is2=to_ros2)

    if not is_same_wireformat(source, target, name, target_name):
        return migrate
    if to_ros2:
        return partial(target.ros1_to_cdr, typename=target_name)

    def to_ros1(data: bytes) -> memoryview:
        is_little_endian = data[:2] == b"\x00\x01"
        return source.cdr_to_ros1(data, name) if is_little_endian else migrate(data)

    return to_ros1


def make_special_converter(ros1_name: str, definition: str, name: str, *, to_ros2: bool) -> Converter | None:
    """Return the function that converts messages of a standard type, such as rosgraph_msgs/Log, whose fields have other
    names or values in ROS 2; None if there is no rule for the two types.

    Args:
        ros1_name: the type in ROS 1, ``package/Type``.
        definition: its definition in ROS 1, followed by the definitions of all types that it uses.
        name: the type in ROS 2, ``package/msg/Type``.
        to_ros2: as for `make_converter`.

    Raises:
        DefinitionError: ``definition`` is not the standard one.
    """
    if (ros1_name, name) not in STANDARD_FIELDS:
        return None
    texts = split_full_text(ros1_name, definition)
    specs = {each: parse_message(each, text) for each, text in texts.items()}
    transcoder = Transcoder(ros1_name, specs, name, distribution_types())
    convert = transcoder.to_cdr if to_ros2 else transcoder.from_cdr
    return lambda data: memoryview(convert(data))
