"""Writes ROS 1 definitions for types that only ROS 2 has."""

from __future__ import annotations

from collections.abc import Callable

from pyros1.ground.errors import UnknownTypeError
from pyros1.msgs.digest import Digests
from pyros1.msgs.spec import HEADER_TYPE, MessageSpec, parse_message
from pyros1.ros2_types.model import Field, Length, Types
from pyros1.ros2_types.nesting import all_types, find_type

_BASES = {
    "builtin_interfaces/msg/Time": "time",
    "builtin_interfaces/msg/Duration": "duration",
    "wstring": "string",
}
_HEADER_TEXT = "uint32 seq\ntime stamp\nstring frame_id\n"


def ros1_definition(
    name: str,
    types: Types,
    to_ros1: Callable[[str], str],
    find_installed: Callable[[str], MessageSpec | None],
) -> str:
    """Return the ROS 1 definition of a ROS 2 type, followed by the definitions of the types that it uses.

    Types that ROS 1 has keep their definitions. In others, strings and sequences lose their maximum lengths, since
    ROS 1 has none, and ``wstring`` becomes ``string``. A ``byte`` keeps its 8 bits, although it ranges from -128 to 127
    in ROS 1, and from 0 to 255 in ROS 2. Constants are left out.

    Args:
        name: full name of a message type, or of a part of a service or action.
        types: the type and all types that it uses.
        to_ros1: returns the name of a type in ROS 1, see `pyros1.ros2_types.counterparts.Counterparts.to_ros1`.
        find_installed: returns ROS 1's definition of a type, by its ROS 1 name; None if ROS 1 does not have the type.

    Returns:
        A text in the format of the field ``message_definition`` of connection headers.

    Raises:
        UnknownTypeError: a type is missing.
        DefinitionError: a type contains itself, is nested too deeply, or its name is not legal in ROS 1.
    """
    names = {to_ros1(each): each for each in all_types([name], types) if each != name}
    ros1_name = to_ros1(name)
    names[ros1_name] = name

    def resolve(wanted: str) -> MessageSpec:
        installed = find_installed(wanted)
        if installed is not None:
            return installed
        if wanted == HEADER_TYPE:
            return parse_message(wanted, _HEADER_TEXT)
        if wanted not in names:
            raise UnknownTypeError(f"the definition of [{wanted}] is missing")
        fields = find_type(names[wanted], types).fields
        return parse_message(wanted, "".join(_render(field, to_ros1) for field in fields))

    return Digests(resolve).full_text(resolve(ros1_name))


def _render(field: Field, to_ros1: Callable[[str], str]) -> str:
    """Return the line that defines a field."""
    base = _BASES.get(field.type.base, field.type.base)
    if "/" in base:
        base = to_ros1(base)
    brackets = {Length.SINGLE: "", Length.FIXED: f"[{field.type.size}]"}.get(field.type.length, "[]")
    return f"{base}{brackets} {field.name}\n"
