"""Reads values from rviz files, which are untrusted: anything that rviz would not write counts as absent (no I/O)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

MAX_NAME_LENGTH = 200
"""Maximum length of names and topics; longer names are treated as absent."""


class Properties(Mapping[Any, Any]):
    """A mapping of properties that remembers which were read: the others are reported as not supported."""

    def __init__(self, values: Mapping[Any, Any]) -> None:
        self._values = values
        self._used_keys: set[Any] = set()
        self._nested: dict[Any, Properties] = {}

    def __getitem__(self, key: Any) -> Any:
        value = self._values[key]
        if isinstance(value, dict):
            return self._nested.setdefault(key, Properties(value))
        self._used_keys.add(key)
        return value

    def __iter__(self) -> Iterator[Any]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def mark_unread(self, key: Any) -> None:
        """Mark a property as unread, because its value is not supported."""
        self._used_keys.discard(key)

    def unread(self) -> Iterator[tuple[str, Any]]:
        """Yield the names and values of unread properties. Nested properties have names such as ``Line
        Style/Value``.
        """
        for key, value in self._values.items():
            if isinstance(value, dict):
                for name, child in self._nested.get(key, Properties(value)).unread():
                    yield f"{key}/{name}", child
            elif key not in self._used_keys:
                yield str(key), value


def mapping_or_empty(value: Any) -> Mapping[Any, Any]:
    """Return the value if it is a mapping, else an empty mapping."""
    return value if isinstance(value, (dict, Properties)) else {}


def list_or_empty(value: Any) -> Sequence[Any]:
    """Return the value if it is a list, else an empty sequence."""
    return value if isinstance(value, list) else ()


def text(values: Mapping[Any, Any], *keys: str) -> str:
    """Return, as a string, the first of several properties that is a string or an integer; empty if none is."""
    for key in keys:
        value = values.get(key)
        if isinstance(value, (str, int)) and not isinstance(value, bool) and 0 < len(str(value)) <= MAX_NAME_LENGTH:
            return str(value)
    return ""


def number(values: Mapping[Any, Any], key: str, minimum: float, maximum: float) -> float | None:
    """Return a property that is a number, limited to a range; None if it is not a number."""
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e9:
        return None
    return min(maximum, max(minimum, float(f"{value:.7g}") if isinstance(value, float) else value))


def mapped_choice(values: Mapping[Any, Any], choices: Mapping[str, Any], key: str) -> Any:
    """Return the panel's value for a property that is one of several choices; None if it is absent or not supported."""
    choice = text(values, key)
    if choice and choice not in choices and isinstance(values, Properties):
        values.mark_unread(key)
    return choices.get(choice)


def boolean(values: Mapping[Any, Any], key: str) -> bool | None:
    """Return a property that is a boolean; None if it is not a boolean."""
    value = values.get(key)
    return value if isinstance(value, bool) else None


def point(values: Any) -> list[float]:
    """Return the properties X, Y and Z, with 0 for each that is absent."""
    return [number(mapping_or_empty(values), axis, -1e6, 1e6) or 0.0 for axis in "XYZ"]


def colour(values: Mapping[Any, Any], key: str = "Color") -> str | None:
    """Return a colour, which rviz writes like ``25; 255; 0``, as ``#rrggbb``; None if it is absent."""
    parts = str(values.get(key, ""))[:20].split(";")
    try:
        numbers = [int(part) for part in parts]
    except ValueError:
        return None
    if len(numbers) != 3 or not all(0 <= number <= 255 for number in numbers):
        return None
    return "#" + "".join(f"{number:02x}" for number in numbers)


def drop_none(**options: Any) -> dict[str, Any]:
    """Return the options that are not None."""
    return {name: value for name, value in options.items() if value is not None}


def class_of(values: Mapping[Any, Any]) -> str:
    """Return the last part of an object's class: ``LaserScan`` for ``rviz/LaserScan``; empty if it is absent."""
    return text(values, "Class").rpartition("/")[2]
