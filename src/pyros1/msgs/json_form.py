"""Messages as JSON values and back: for ``topic echo --json``, ``topic pub`` and programs that are not ROS's. Pure.

A message is an object of its fields; a time or duration ``{"secs": 1, "nsecs": 2}``; ``uint8[]`` and ``char[]`` are
base64 text; floats that JSON has no numbers for are ``"NaN"``, ``"Infinity"`` and ``"-Infinity"``.
"""

from __future__ import annotations

import base64
import binascii
import math
from typing import Any

from pyros1.errors import MessageError
from pyros1.msgs.base import Message, message_class
from pyros1.msgs.fill import fill_message
from pyros1.timing import Time, TVal

_NO_NUMBERS = ("NaN", "Infinity", "-Infinity")
_FLOATS = ("float32", "float64")
_BYTES = ("uint8", "char")


def to_json(value: Any, type_name: str | None = None) -> Any:  # noqa: PLR0911 - one form, one line
    """Return what `json.dumps` writes without loss.

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
    if base in _BYTES:
        return base64.b64encode(bytes(value)).decode("ascii")
    return [to_json(item, base) for item in value]


def from_json(cls: type[Message], value: Any, now: Time | None = None) -> Message:
    """Make a message from what `to_json` returned; fields that are not named keep their defaults.

    Args:
        now: the time that the words ``now`` and ``auto`` stand for, as in `fill_message`.

    Raises:
        MessageError: a value has not the form of its field; the text names the field.
    """
    message = cls()
    fill_message(message, _plain(cls, value, ""), now)
    return message


def _plain(cls: type[Message], value: Any, prefix: str) -> Any:
    """The value with all texts that stand for bytes and numbers replaced."""
    if not isinstance(value, dict):
        return value
    types = dict(zip(cls.__slots__, cls._slot_types, strict=True))
    return {
        name: _field(cls, types[name], item, prefix + name) if name in types else item for name, item in value.items()
    }


def _field(cls: type[Message], slot_type: str, value: Any, path: str) -> Any:
    base, bracket, _ = slot_type.partition("[")
    if bracket and base in _BYTES and isinstance(value, str):
        try:
            return base64.b64decode(value, validate=True)
        except (binascii.Error, ValueError):
            raise MessageError(f"Field [{path}] must be base64 text or a list of numbers") from None
    if bracket and isinstance(value, list):
        return [_field(cls, base, item, f"{path}[{number}]") for number, item in enumerate(value)]
    if base in _FLOATS and isinstance(value, str):
        if value not in _NO_NUMBERS:
            raise MessageError(f"Field [{path}] must be a number instead of: {value!r}")
        return float(value)
    nested = cls._classes.get(base)
    return value if nested is None else _plain(nested, value, path + ".")
