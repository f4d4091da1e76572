"""ROS 1 and ROS 2 types out of rosbags' stores, as the transcoder wants them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from pyros1.msgs.digest import split_full_text
from pyros1.msgs.spec import MessageSpec, parse_message
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType


@cache
def ros1_store() -> Typestore:
    """Return ROS Noetic's types."""
    return get_typestore(Stores.ROS1_NOETIC)


@cache
def ros2_store() -> Typestore:
    """Return ROS 2 Jazzy's types."""
    return get_typestore(Stores.ROS2_JAZZY)


def ros1_specs(name: str) -> Mapping[str, MessageSpec]:
    """Return a ROS 1 type, ``package/Type``, and the types that it uses."""
    text, _ = ros1_store().generate_msgdef(name.replace("/", "/msg/"))
    return {name: parse_message(name, part) for name, part in split_full_text(name, text).items()}


@cache
def ros2_types() -> Mapping[str, MessageType]:
    """Return all types of ROS 2 Jazzy."""
    return {
        name: MessageType(name, tuple(Field(field, _field_type(description)) for field, description in fields))
        for name, (_, fields) in ros2_store().fielddefs.items()
    }


def _field_type(description: Any) -> FieldType:
    kind, detail = description
    if kind == Nodetype.BASE:
        base, bound = detail
        return FieldType({"octet": "byte", "char": "uint8"}.get(base, base), string_bound=bound)
    if kind == Nodetype.NAME:
        return FieldType(detail)
    element, size = detail
    length = Length.FIXED if kind == Nodetype.ARRAY else Length.BOUNDED if size else Length.UNBOUNDED
    return _field_type(element)._replace(length=length, size=size)
