"""Message templates: YAML with a value for each field, to fill in (rosmsg-proto, L89).

Short collections are written on several lines, long ones and all following ones in brackets.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from pyros1.msgs import Message
from pyros1.msgs.base import nested_classes
from pyros1.values.writing import dump

LONG = 4
"""Maximum number of entries of a short collection."""


def template(
    cls: type[Message],
    flow_style: int | None = None,
    *,
    empty_arrays: bool = False,
    excluded: Collection[str] = (),
) -> str:
    """Return a template of a message as YAML, without a line break at its end.

    Args:
        cls: the message's class.
        flow_style: 1 puts everything in brackets, 0 nothing. None uses brackets for the innermost collections,
            starting at the first field with a long collection, or for all fields if there are many or one is a long
            array.
        empty_arrays: whether arrays of variable length have no element.
        excluded: names of fields to leave out, at any depth.
    """
    return _render(_Maker(empty_arrays, excluded).message(cls()), flow_style)


class _Maker:
    """Converts messages to dictionaries; arguments as for `template`."""

    def __init__(self, empty_arrays: bool, excluded: Collection[str]) -> None:
        self._empty_arrays = empty_arrays
        self._excluded = excluded

    def message(self, message: Message) -> dict[str, Any]:
        """Return the message as dictionaries, with one element in each array of variable length."""
        classes = nested_classes(type(message))
        return {
            name: self._field(getattr(message, name), kind, classes)
            for name, kind in zip(message.__slots__, message._slot_types, strict=True)
            if name not in self._excluded
        }

    def _field(self, value: Any, slot_type: str, classes: Any) -> Any:
        base, bracket, length = slot_type.partition("[")
        if bracket:
            if base in ("uint8", "char"):
                return bytes(value)
            if length == "]" and not self._empty_arrays:
                value = [_element(base, classes)]
            return [self._field(item, base, classes) for item in value]
        if isinstance(value, Message):
            return self.message(value)
        if base in ("time", "duration"):
            return {"secs": value.secs, "nsecs": value.nsecs}
        return value


def _element(base: str, classes: Any) -> Any:
    if base in classes:
        return classes[base]()
    if base in ("time", "duration"):
        from pyros1.ground.timing import Duration, Time  # noqa: PLC0415

        return Time() if base == "time" else Duration()
    return "" if base == "string" else 0


# Layout ---------------------------------------------------------------------------------------------------------------


def _render(value: dict[str, Any], flow_style: int | None) -> str:
    brackets: set[int] = set()
    if flow_style == 1:
        brackets.add(id(value))
    elif flow_style != 0:
        _choose(value, brackets, False)
    return dump(value, inline=lambda part: id(part) in brackets, ordered=True).rstrip("\n")


def _parts(value: Any) -> list[Any]:
    return list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []


def _choose(value: Any, brackets: set[int], found: bool) -> bool:
    """Choose which collections get brackets. Return whether a long collection was found."""
    parts = _parts(value)
    if found or len(parts) > LONG or any(isinstance(part, list) and len(part) > LONG for part in parts):
        _add_leaves(value, brackets)
        return True
    for part in parts:
        found = _choose(part, brackets, found)
    return found


def _add_leaves(value: Any, brackets: set[int]) -> None:
    parts = _parts(value)
    if isinstance(value, (dict, list)) and not any(isinstance(part, (dict, list)) for part in parts):
        brackets.add(id(value))
    for part in parts:
        _add_leaves(part, brackets)
