"""The field names of a message class, in the order in which values are given on the command line (L68, L76)."""

from __future__ import annotations

from pyros1.msgs import Message
from pyros1.msgs.base import nested_classes


def argument_names(message_class: type[Message], prefix: str = "") -> list[str]:
    """Return the names of all fields of a message class, with paths such as ``header.stamp`` for nested messages."""
    names: list[str] = []
    for name, slot_type in zip(message_class.__slots__, message_class._slot_types, strict=True):
        nested_class = nested_classes(message_class).get(slot_type)
        names += argument_names(nested_class, f"{prefix}{name}.") if nested_class is not None else [prefix + name]
    return names
