"""The fields of messages as columns: their paths, values and types, and a field of many messages as one numpy array."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from pyros1.ground.timing import Duration, Time
from pyros1.msgs.base import Message, nested_classes

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DTYPES = {"bool": "?", "byte": "int8", "char": "uint8", "time": "float64", "duration": "float64"}
_NUMBER_TYPES = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"}


def to_array(values: Sequence[Any], type_name: str) -> NDArray[Any]:
    """Return a field's values as one array.

    Args:
        values: n values, one per message; times in seconds.
        type_name: the field's type, for example ``float32`` or ``uint8[]``.

    Returns:
        An array of that type, of shape (n,), or (n, length) if the values are arrays of equal length. Otherwise an
        array of objects, of shape (n,).
    """
    import numpy as np  # noqa: PLC0415 - slow to import, and only columns need it

    base, bracket, _ = type_name.partition("[")
    dtype = _DTYPES.get(base, base if base in _NUMBER_TYPES else None)
    if dtype is not None and not bracket:
        return np.array(values, dtype)
    if dtype is not None and base not in ("time", "duration"):
        rows = [
            np.frombuffer(value, dtype) if isinstance(value, (bytes, bytearray)) else np.array(value, dtype)
            for value in values
        ]
        if len({len(row) for row in rows}) <= 1:
            return np.array(rows, dtype).reshape(len(rows), -1)
        values = rows
    objects = np.empty(len(values), object)
    for index, value in enumerate(values):
        objects[index] = value
    return objects


def leaf_paths(message: Message, prefix: str = "") -> Iterator[str]:
    """Yield the paths of a message's fields that are single values, such as ``pose.position.x``."""
    for name in message.__slots__:
        value = getattr(message, name)
        if isinstance(value, Message):
            yield from leaf_paths(value, f"{prefix}{name}.")
        elif isinstance(value, (bool, int, float, str, Time, Duration)):
            yield prefix + name


def field_value(value: Any, path: str) -> Any:
    """Return the value of a message's field; times are in seconds."""
    for name in path.split("."):
        value = getattr(value, name)
    return value.to_sec() if isinstance(value, (Time, Duration)) else value


def field_type(cls: type[Message], path: str) -> str:
    """Return a field's type, for example ``float32[]``; empty if the message has no such field."""
    type_name = ""
    for name in path.split("."):
        if type_name in ("time", "duration"):
            return "int64"
        if type_name:
            cls = nested_classes(cls)[type_name]
        type_name = dict(zip(cls.__slots__, cls._slot_types, strict=True)).get(name, "")
    return type_name
