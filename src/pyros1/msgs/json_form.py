"""Converts messages to JSON values and back, for ``topic echo --json``, ``topic pub`` and programs outside ROS.
Does no I/O.

A message is an object with its fields; a time or duration is ``{"secs": 1, "nsecs": 2}``; ``uint8[]`` and ``char[]``
are base64 strings; floats that are not JSON numbers are ``"NaN"``, ``"Infinity"`` and ``"-Infinity"``. `from_json` also
accepts an int64 or uint64 as a string, since JavaScript cannot represent integers beyond 2^53.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import re
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time, TVal
from pyros1.msgs.base import Message, message_class
from pyros1.msgs.fill import fill_message

_SPECIAL_FLOATS = ("NaN", "Infinity", "-Infinity")
_FLOAT_TYPES = ("float32", "float64")
_UINT8_TYPES = ("uint8", "char")
_INT64_TYPES = ("int64", "uint64")
_INTEGER_PATTERN = re.compile(r"-?[0-9]{1,20}\Z")
_SLICE_SIZE = 3 << 12
"""Number of bytes, characters or numbers that are converted at a time; a multiple of three, as base64 requires."""

_dumps = json.JSONEncoder(ensure_ascii=False).encode


def to_json(value: Any, type_name: str | None = None) -> Any:  # noqa: PLR0911 - one return per form
    """Convert a value to one that `json.dumps` writes without loss.

    Args:
        value: a message, or a field's value.
        type_name: the type of a field's value, for example ``uint8[]``.
    """
    if isinstance(value, Message):
        cls = message_class(type(value))
        pairs = zip(cls.__slots__, cls._slot_types, strict=True)
        return {name: to_json(getattr(value, name), slot_type) for name, slot_type in pairs}
    if isinstance(value, TVal):
        return {"secs": value.secs, "nsecs": value.nsecs}
    if isinstance(value, (bytes, bytearray, memoryview)):
        return base64.b64encode(value).decode("ascii")
    if isinstance(value, float):
        return value if math.isfinite(value) else "NaN" if math.isnan(value) else f"{'-' * (value < 0)}Infinity"
    if isinstance(value, (str, int)) or value is None:
        return value
    base = type_name.partition("[")[0] if type_name is not None else None
    if base in _UINT8_TYPES:
        return base64.b64encode(bytes(value)).decode("ascii")
    return [to_json(item, base) for item in value]


def emit_json(
    emit: Callable[[str], object],
    value: Any,
    type_name: str | None = None,
    *,
    includes: Callable[[str], bool] = lambda field_type: True,
) -> None:
    """Emit the JSON of a value in pieces, so that the whole text is never in memory.

    Args:
        emit: called with each piece.
        value: as for `to_json`.
        type_name: as for `to_json`.
        includes: returns whether to include fields of a given type.
    """
    if isinstance(value, Message):
        cls = message_class(type(value))
        separator = "{"
        for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
            if includes(slot_type):
                emit(f'{separator}"{name}": ')
                emit_json(emit, getattr(value, name), slot_type, includes=includes)
                separator = ", "
        emit("}" if separator == ", " else "{}")
    elif isinstance(value, str) and len(value) > _SLICE_SIZE:
        emit('"')
        for start in range(0, len(value), _SLICE_SIZE):
            emit(_dumps(value[start : start + _SLICE_SIZE])[1:-1])
        emit('"')
    elif isinstance(value, (bytes, bytearray, memoryview)):
        emit('"')
        for start in range(0, len(value), _SLICE_SIZE):
            emit(base64.b64encode(value[start : start + _SLICE_SIZE]).decode("ascii"))
        emit('"')
    elif isinstance(value, (list, tuple)) and value and (type_name or "").partition("[")[0] not in _UINT8_TYPES:
        _emit_array(emit, value, type_name, includes)
    else:
        emit(_dumps(to_json(value, type_name)))


def _emit_array(
    emit: Callable[[str], object], values: Any, type_name: str | None, includes: Callable[[str], bool]
) -> None:
    base = type_name.partition("[")[0] if type_name is not None else None
    separator = "["
    if isinstance(values[0], (int, float, TVal)):
        for start in range(0, len(values), _SLICE_SIZE):
            emit(separator + _dumps([to_json(item, base) for item in values[start : start + _SLICE_SIZE]])[1:-1])
            separator = ", "
    else:
        for item in values:
            emit(separator)
            emit_json(emit, item, base, includes=includes)
            separator = ", "
    emit("]")


def from_json(cls: type[Message], value: Any, now: Time | None = None) -> Message:
    """Convert a value in the form that `to_json` returns to a message; missing fields get their defaults.

    Args:
        now: the time that the strings ``now`` and ``auto`` stand for, as in `fill_message`.

    Raises:
        MessageError: a value does not fit its field; the message names the field.
    """
    message = cls()
    fill_message(message, _to_plain(cls, value, ""), now)
    return message


def _to_plain(cls: type[Message], value: Any, prefix: str) -> Any:
    """Return the value with bytes in place of base64 strings, and floats in place of the names of special floats."""
    if not isinstance(value, dict):
        return value
    types = dict(zip(cls.__slots__, cls._slot_types, strict=True))
    return {
        name: _field_to_plain(cls, types[name], item, prefix + name) if name in types else item
        for name, item in value.items()
    }


def _field_to_plain(cls: type[Message], slot_type: str, value: Any, path: str) -> Any:
    base, bracket, _ = slot_type.partition("[")
    if bracket and base in _UINT8_TYPES and isinstance(value, str):
        try:
            return base64.b64decode(value, validate=True)
        except (binascii.Error, ValueError):
            raise MessageError(f"Field [{path}] must be base64 text or a list of numbers") from None
    if bracket and isinstance(value, list):
        return [_field_to_plain(cls, base, item, f"{path}[{index}]") for index, item in enumerate(value)]
    if base in _FLOAT_TYPES and isinstance(value, str):
        if value not in _SPECIAL_FLOATS:
            raise MessageError(f"Field [{path}] must be a number instead of: {value!r}")
        return float(value)
    if base in _INT64_TYPES and isinstance(value, str) and _INTEGER_PATTERN.match(value):
        return int(value)
    nested = cls._classes.get(base)
    return value if nested is None else _to_plain(nested, value, path + ".")
