"""Creates message and service classes from parsed definitions, within limits."""

from __future__ import annotations

import keyword
import struct
from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.errors import DefinitionError
from pyros1.msgs.base import Message, MessageType, Service
from pyros1.msgs.digest import Digests
from pyros1.msgs.spec import STRUCT_CODES, Field, MessageSpec, ServiceSpec

MAX_WEIGHT = 1 << 28
"""Maximum approximate memory of a type's default value in bytes, since arrays of fixed length may be huge."""

MAX_EMPTY_ELEMENTS = 16
"""Maximum number of elements of an array of empty messages: they take no bytes, so the data received set no limit."""

MAX_EMPTY_MESSAGES = 32
"""Maximum number of messages, including nested ones, in a field that is encoded in 0 bytes: otherwise, a few bytes
could create any number of messages.
"""

MESSAGE_WEIGHT = 64
"""Approximate memory of a message without its values, in bytes."""


def python_name(name: str) -> str:
    """Return the attribute name for a field or constant: an underscore is appended to Python's keywords (G10)."""
    return name + "_" if keyword.iskeyword(name) or name == "self" else name


def make_message_class(
    spec: MessageSpec, digests: Digests, lookup: Callable[[str], type[Message]], module: str
) -> type[Message]:
    """Return a new class for a message type.

    Args:
        spec: the parsed definition.
        digests: computes the md5 sum and the full text.
        lookup: returns the class of a field's message type.
        module: ``__module__`` of the class.

    Raises:
        DefinitionError: the type contains itself or is too large, or a name occurs twice.
    """
    md5sum = digests.md5(spec)  # computed first, since this rejects types that contain themselves
    classes = {field.base: lookup(field.base) for field in spec.fields if not field.is_builtin}
    constants = {python_name(constant.name): constant.value for constant in spec.constants}
    slots = [python_name(field.name) for field in spec.fields]
    if not constants.keys().isdisjoint(slots):
        raise DefinitionError("a field and a constant have the same name", spec.name)
    if len({*slots}) < len(slots):  # such fields would be the same attribute
        duplicate = next(name for name in slots if slots.count(name) > 1)
        raise DefinitionError(f"two fields have the name [{duplicate}] in Python", spec.name)
    min_size, weight, is_fixed = 0, MESSAGE_WEIGHT, True
    for field in spec.fields:
        size, field_weight, is_field_fixed = field_size(field, classes)
        min_size, weight, is_fixed = min_size + size, weight + field_weight, is_fixed and is_field_fixed
        if weight > MAX_WEIGHT:
            raise DefinitionError(f"field [{field.name}] makes the type too large", spec.name)
        if size == 0 and field_weight > MESSAGE_WEIGHT * MAX_EMPTY_MESSAGES:
            amount = f"{field_weight // MESSAGE_WEIGHT} messages without content; the limit is {MAX_EMPTY_MESSAGES}"
            raise DefinitionError(f"field [{field.name}] contains {amount}", spec.name)
    short_name = spec.name.partition("/")[2]
    members: dict[str, Any] = {
        "__slots__": slots,
        "__module__": module,
        "__qualname__": short_name,
        "__doc__": _docstring(spec.text) or f"Message type {spec.name}, without fields.",
        **constants,
        "_type": spec.name,
        "_md5sum": md5sum,
        "_text_source": (digests, spec),
        "_has_header": spec.has_header,
        "_slot_types": [field.type for field in spec.fields],
        "_fixed_size": min_size if is_fixed else None,
        "_min_size": min_size,
        "_weight": weight,
        "_classes": classes,
    }
    try:
        cls: Any = MessageType(short_name, (Message,), members)
    except (TypeError, ValueError) as error:
        raise DefinitionError(f"cannot create a class from this definition: {error}", spec.name) from error
    message_class: type[Message] = cls
    return message_class


def make_service_class(
    spec: ServiceSpec, digests: Digests, lookup: Callable[[str], type[Message]], module: str
) -> type[Service]:
    """Return a new class for a service type, with its request and response classes; arguments and errors as for
    `make_message_class`.
    """
    short_name = spec.name.partition("/")[2]
    members: dict[str, Any] = {
        "__module__": module,
        "__doc__": _docstring(spec.text) or f"Service type {spec.name}, without fields.",
        "_type": spec.name,
        "_md5sum": digests.md5(spec),
        "_full_text": digests.full_text(spec),
        "_request_class": make_message_class(spec.request, digests, lookup, module),
        "_response_class": make_message_class(spec.response, digests, lookup, module),
    }
    return type(short_name, (Service,), members)


def _docstring(text: str) -> str:
    """Return a definition as a class's ``__doc__``, with question marks for bytes that are not UTF-8."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


def field_size(field: Field, classes: Mapping[str, type[Message]]) -> tuple[int, int, bool]:
    """Return a field's minimum size and approximate default memory, both in bytes, and whether its size is fixed."""
    if field.length == -1:
        return 4, 64, False
    count = 1 if field.length is None else field.length
    if field.base in STRUCT_CODES:
        size = struct.calcsize("<" + STRUCT_CODES[field.base])
        return size * count, (1 if size == 1 else 8) * count, True
    if field.base == "string":
        return 4 * count, 8 * count, False
    if field.base in ("time", "duration"):
        return 8 * count, 64 * count, True
    cls = classes[field.base]
    return cls._min_size * count, cls._weight * count, cls._fixed_size is not None
