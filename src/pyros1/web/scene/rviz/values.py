"""What rviz's files have as values. They are anybody's: what is not as rviz writes it counts as absent. Pure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

LONGEST_NAME = 200
"""Most characters of names and topics; longer ones count as absent."""


def mapping(value: Any) -> Mapping[Any, Any]:
    """Return the value if it is a mapping, else an empty one."""
    return value if isinstance(value, dict) else {}


def listed(value: Any) -> Sequence[Any]:
    """Return the value if it is a list, else an empty one."""
    return value if isinstance(value, list) else ()


def text(values: Mapping[Any, Any], *keys: str) -> str:
    """Return the first of some entries that is a text, or a number as such; empty if none is."""
    for key in keys:
        value = values.get(key)
        if isinstance(value, (str, int)) and not isinstance(value, bool) and 0 < len(str(value)) <= LONGEST_NAME:
            return str(value)
    return ""


def number(values: Mapping[Any, Any], key: str, least: float, most: float) -> float | None:
    """Return an entry that is a number, within bounds; None if it is none."""
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e9:
        return None
    return min(most, max(least, value))


def flag(values: Mapping[Any, Any], key: str) -> bool | None:
    """Return an entry that is true or false; None if it is neither."""
    value = values.get(key)
    return value if isinstance(value, bool) else None


def point(values: Any) -> list[float]:
    """Return X, Y and Z, 0 for those that are absent."""
    return [number(mapping(values), axis, -1e6, 1e6) or 0.0 for axis in "XYZ"]


def colour(values: Mapping[Any, Any], key: str = "Color") -> str | None:
    """Return a colour as ``#rrggbb``; rviz writes ``25; 255; 0``."""
    parts = str(values.get(key, ""))[:20].split(";")
    try:
        numbers = [int(part) for part in parts]
    except ValueError:
        return None
    if len(numbers) != 3 or not all(0 <= number <= 255 for number in numbers):
        return None
    return "#" + "".join(f"{number:02x}" for number in numbers)


def given(**options: Any) -> dict[str, Any]:
    """Return the options that are not None."""
    return {name: value for name, value in options.items() if value is not None}


def class_of(values: Mapping[Any, Any]) -> str:
    """Return the last part of a class: ``LaserScan`` of ``rviz/LaserScan``."""
    return text(values, "Class").rpartition("/")[2]
