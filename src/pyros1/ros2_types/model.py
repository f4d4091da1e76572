"""The parts of ROS 2 types (https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html) that matter for
encoding and hashing: no defaults, no constants. No I/O.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

STRUCT_CODES = {
    "bool": "?",
    "byte": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""Primitive types with a fixed size and their struct codes; a definition's ``char`` is ``uint8`` here."""

NAME_PART = r"[A-Za-z][A-Za-z0-9_]{0,199}"
"""Matches the name of a package, or of a type in it."""
TYPE_NAME = re.compile(rf"({NAME_PART})/(msg|srv|action)/({NAME_PART})", re.ASCII)
"""Matches a type's full name, in three parts."""
STRINGS = frozenset(["string", "wstring"])


def is_type_name(name: str) -> bool:
    """Return whether this has the form of a type's name in ROS 2, such as ``std_msgs/msg/String``."""
    return TYPE_NAME.fullmatch(name) is not None


class Length(Enum):
    """The number of values of a field: one, a fixed number, up to a maximum, or any number."""

    SINGLE = "one"
    FIXED = "as many as its size says"
    BOUNDED = "at most as many as its size says"
    UNBOUNDED = "any number"


class FieldType(NamedTuple):
    """The type of a field.

    Attributes:
        base: a primitive type, ``string``, ``wstring``, or the full name of another type, for example
            ``std_msgs/msg/Header``.
        length: how many values it has.
        size: number of elements of a fixed array, or maximum number of elements of a bounded sequence.
        string_bound: maximum length of a string; 0 if there is none.
    """

    base: str
    length: Length = Length.SINGLE
    size: int = 0
    string_bound: int = 0

    @property
    def is_nested(self) -> bool:
        """Whether a value, or each element, is a message."""
        return "/" in self.base


class Field(NamedTuple):
    """A field of a message type."""

    name: str
    type: FieldType


class MessageType(NamedTuple):
    """A message type, or a part of a service or action type.

    Attributes:
        name: its full name, for example ``std_msgs/msg/String`` or ``example_interfaces/srv/AddTwoInts_Request``.
        fields: its fields in order; may be empty.
    """

    name: str
    fields: tuple[Field, ...]


Types = Mapping[str, MessageType]
"""Types by their full names; includes all types that these types use."""
