"""Converts the values of a field in many messages to one numpy array."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

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
