"""Reads the type descriptions that rosidl installs as ``.json`` files since ROS 2 Iron. For types defined in ``.idl``
files, there is no other format that pyros1 can read. No I/O.
"""

from __future__ import annotations

import json
from typing import Any

from pyros1.ground.errors import DefinitionError
from pyros1.ros2_types.definitions import MAX_FIELDS, MAX_SIZE
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType
from pyros1.ros2_types.type_hash import BASES, BOUNDED_STRINGS, FILLER

_LENGTHS = (Length.SINGLE, Length.FIXED, Length.BOUNDED, Length.UNBOUNDED)
_STEP = 48


def read_description(text: str) -> dict[str, MessageType]:
    """Return the types in a description: the type itself, and all types that it uses.

    Args:
        text: the content of the file.

    Raises:
        DefinitionError: it is not a description, or contains an unknown field type.
    """
    try:
        message = json.loads(text)["type_description_msg"]
        described = [message["type_description"], *message["referenced_type_descriptions"]]
        if sum(len(each["fields"]) for each in described) > MAX_FIELDS:
            raise DefinitionError(f"more than {MAX_FIELDS} fields")
        return {str(each["type_name"]): _message_type(each) for each in described}
    except (ValueError, KeyError, TypeError, IndexError, OverflowError, RecursionError) as error:
        raise DefinitionError(f"this is not the description of a type: {error!r:.200}") from error


def _message_type(described: Any) -> MessageType:
    fields = [Field(str(each["name"]), _field_type(each["type"])) for each in described["fields"]]
    return MessageType(str(described["type_name"]), tuple(field for field in fields if field != FILLER))


def _field_type(described: Any) -> FieldType:
    number = int(described["type_id"])
    if number < 1:
        raise DefinitionError(f"a field has the unknown type {number}")
    length = _LENGTHS[(number - 1) // _STEP]
    base = BASES.get((number - 1) % _STEP + 1) or str(described["nested_type_name"])
    is_plain = (number - 1) % _STEP + 1 in BASES
    if not is_plain and "/" not in base:
        raise DefinitionError(f"a field has the unknown type {number}")
    size = int(described["capacity"]) if length in (Length.FIXED, Length.BOUNDED) else 0
    string_bound = int(described["string_capacity"])
    is_bounded = (number - 1) % _STEP + 1 in BOUNDED_STRINGS
    for value, is_needed in ((size, length in (Length.FIXED, Length.BOUNDED)), (string_bound, is_bounded)):
        if not is_needed <= value <= (MAX_SIZE if is_needed else 0):
            raise DefinitionError(f"a field of type {number} has an invalid size")
    return FieldType(base, length, size, string_bound)
