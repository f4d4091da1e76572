"""Computes type hashes (RIHS01, https://github.com/ros-infrastructure/rep/pull/381), by which ROS 2 compares types.

The hash covers the names and types of all fields, in the type and the types that it uses, but no defaults, constants or
comments. No I/O.
"""

from __future__ import annotations

import json
from hashlib import sha256

from pyros1.ros2_types.interfaces import service_types, whole_action_types
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType, Types
from pyros1.ros2_types.nesting import LayeredTypes, all_types

_PREFIX = "RIHS01_"

# The numbers in type_description_interfaces/msg/FieldType.
_NESTED_ID = 1
_TYPE_IDS = {
    "int8": 2,
    "uint8": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "bool": 15,
    "byte": 16,
    "string": 17,
    "wstring": 18,
}
_BOUNDED_STRING_IDS = {"string": 21, "wstring": 22}
BASES = {number: base for ids in (_TYPE_IDS, _BOUNDED_STRING_IDS) for base, number in ids.items()}
"""The primitive types and strings, by their numbers in type_description_interfaces/msg/FieldType."""
BOUNDED_STRINGS = frozenset(_BOUNDED_STRING_IDS.values())
"""The numbers of strings with a maximum length in type_description_interfaces/msg/FieldType."""
_LENGTH_OFFSETS = {Length.SINGLE: 0, Length.FIXED: 48, Length.BOUNDED: 96, Length.UNBOUNDED: 144}

FILLER = Field("structure_needs_at_least_one_member", FieldType("uint8"))
"""rosidl adds this field to types without any, since a C struct cannot be empty."""


def type_hash(name: str, types: Types) -> str:
    """Return the hash of a message type, or of a part of a service or an action.

    Args:
        name: full name, for example ``std_msgs/msg/String`` or ``std_srvs/srv/SetBool_Request``.
        types: the type and all types that it uses.

    Returns:
        ``RIHS01_`` and 64 hexadecimal digits.

    Raises:
        UnknownTypeError: a type is missing.
        DefinitionError: a type contains itself, or is nested too deeply.
    """
    used = sorted(set(all_types([name], types)) - {name})
    description = {
        "type_description": _describe(types[name]),
        "referenced_type_descriptions": [_describe(types[each]) for each in used],
    }
    return _PREFIX + sha256(json.dumps(description).encode()).hexdigest()


def service_hash(name: str, types: Types) -> str:
    """Return the hash of a service type.

    Args:
        name: full name, for example ``std_srvs/srv/SetBool``, or of one of an action's two services,
            ``example_interfaces/action/Fibonacci_SendGoal``.
        types: the types of request and response, and all types that they use. An action's services need the action's
            goal and result.

    Raises:
        UnknownTypeError, DefinitionError: as for `type_hash`.
    """
    return type_hash(name, LayeredTypes(service_types(name, types), types))


def action_hash(name: str, types: Types) -> str:
    """Return the hash of an action type.

    Args:
        name: full name, for example ``example_interfaces/action/Fibonacci``.
        types: the types of goal, result and feedback, and all types that they use.

    Raises:
        UnknownTypeError, DefinitionError: as for `type_hash`.
    """
    return type_hash(name, LayeredTypes(whole_action_types(name, types), types))


def _describe(message_type: MessageType) -> dict[str, object]:
    fields = message_type.fields or (FILLER,)
    # The keys must be in this order, since the JSON text is hashed.
    return {
        "type_name": message_type.name,
        "fields": [{"name": field.name, "type": _describe_field_type(field.type)} for field in fields],
    }


def _describe_field_type(field_type: FieldType) -> dict[str, object]:
    if field_type.is_nested:
        type_id = _NESTED_ID
    elif field_type.string_bound:
        type_id = _BOUNDED_STRING_IDS[field_type.base]
    else:
        type_id = _TYPE_IDS[field_type.base]
    return {
        "type_id": type_id + _LENGTH_OFFSETS[field_type.length],
        "capacity": field_type.size,
        "string_capacity": field_type.string_bound,
        "nested_type_name": field_type.base if field_type.is_nested else "",
    }
