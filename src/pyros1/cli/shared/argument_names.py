"""The fields of a message as a person has to give them: ``header.seq header.stamp pose.position.x`` (L68, L76)."""

from __future__ import annotations

from pyros1.msgs import Message
from pyros1.msgs.base import nested_classes


def argument_names(message_class: type[Message], prefix: str = "") -> list[str]:
    """The names of all fields, those of nested messages with a path before them."""
    names: list[str] = []
    for name, slot_type in zip(message_class.__slots__, message_class._slot_types, strict=True):
        nested = nested_classes(message_class).get(slot_type)
        names += argument_names(nested, f"{prefix}{name}.") if nested is not None else [prefix + name]
    return names
