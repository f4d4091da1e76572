"""Message templates: YAML with a default value for each field (rosmsg-proto, L89).

Short collections are written on several lines. Long ones, and all that follow them, are written in brackets.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from pyros1.msgs import Message
from pyros1.msgs.base import nested_classes
from pyros1.values.writing import dump

MAX_SHORT_LENGTH = 4
"""Maximum number of items in a short collection."""


def template(
    cls: type[Message],
    flow_style: int | None = None,
    *,
    empty_arrays: bool = False,
    excluded: Collection[str] = (),
) -> str:
    """Return the template of a message as YAML without a trailing line break.

    Args:
        cls: the class of the message.
        flow_style: 1 to use brackets for all collections, 0 for none. If this is None, only the innermost collections
            are in brackets, starting at the first field with a long collection. If there are many fields, or one is a
            long array, that applies to all fields.
        empty_arrays: whether arrays of variable length are empty.
        excluded: the names of fields to leave out at any depth.
    """
    return _render(_TemplateBuilder(empty_arrays, excluded).to_dict(cls()), flow_style)


class _TemplateBuilder:
    """Converts messages to dictionaries. The arguments are those of `template`."""

    def __init__(self, empty_arrays: bool, excluded: Collection[str]) -> None:
        self._empty_arrays = empty_arrays
        self._excluded = excluded

    def to_dict(self, message: Message) -> dict[str, Any]:
        """Return the message as a dictionary with one element in each array of variable length."""
        classes = nested_classes(type(message))
        return {
            name: self._field(getattr(message, name), slot_type, classes)
            for name, slot_type in zip(message.__slots__, message._slot_types, strict=True)
            if name not in self._excluded
        }

    def _field(self, value: Any, slot_type: str, classes: Any) -> Any:
        base, bracket, length = slot_type.partition("[")
        if bracket:
            if base in ("uint8", "char"):
                return bytes(value)
            if length == "]" and not self._empty_arrays:
                value = [_default_element(base, classes)]
            return [self._field(item, base, classes) for item in value]
        if isinstance(value, Message):
            return self.to_dict(value)
        if base in ("time", "duration"):
            return {"secs": value.secs, "nsecs": value.nsecs}
        return value


def _default_element(type_name: str, classes: Any) -> Any:
    if type_name in classes:
        return classes[type_name]()
    if type_name in ("time", "duration"):
        from pyros1.ground.timing import Duration, Time  # noqa: PLC0415

        return Time() if type_name == "time" else Duration()
    return "" if type_name == "string" else 0


# Layout ---------------------------------------------------------------------------------------------------------------


def _render(value: dict[str, Any], flow_style: int | None) -> str:
    bracketed: set[int] = set()
    if flow_style == 1:
        bracketed.add(id(value))
    elif flow_style != 0:
        _select_bracketed(value, bracketed, False)
    return dump(value, is_inline=lambda part: id(part) in bracketed, ordered=True).rstrip("\n")


def _parts_of(value: Any) -> list[Any]:
    return list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []


def _select_bracketed(value: Any, bracketed: set[int], found_long: bool) -> bool:
    """Add the ids of the collections to write in brackets. Return whether a long collection was found."""
    parts = _parts_of(value)
    if (
        found_long
        or len(parts) > MAX_SHORT_LENGTH
        or any(isinstance(part, list) and len(part) > MAX_SHORT_LENGTH for part in parts)
    ):
        _add_innermost(value, bracketed)
        return True
    for part in parts:
        found_long = _select_bracketed(part, bracketed, found_long)
    return found_long


def _add_innermost(value: Any, bracketed: set[int]) -> None:
    parts = _parts_of(value)
    if isinstance(value, (dict, list)) and not any(isinstance(part, (dict, list)) for part in parts):
        bracketed.add(id(value))
    for part in parts:
        _add_innermost(part, bracketed)
