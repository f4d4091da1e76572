"""Messages as clients see them, and as they write them. Pure.

As JSON, ``uint8[]`` and ``char[]`` are base64 texts, and numbers that JSON lacks are null. As CBOR, arrays of numbers
are the bytes of the message, with tags that name their type
(https://datatracker.ietf.org/doc/html/draft-ietf-cbor-array-tags-00).
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.msgs import Message
from pyros1.msgs.array_views import numpy_view
from pyros1.msgs.json_form import from_json
from pyros1.web.rosbridge.frames import tagged

_BYTES = ("uint8", "char")
_FLOATS = ("float32", "float64")
_TAGS = {
    "uint16": 69,
    "uint32": 70,
    "uint64": 71,
    "int8": 72,
    "byte": 72,
    "int16": 77,
    "int32": 78,
    "int64": 79,
    "float32": 85,
    "float64": 86,
}
"""Of arrays whose bytes are little endian."""
_HEADER = "std_msgs/Header"
_Convert = Callable[[Any], Any]
_view = numpy_view(np)


def decode(cls: type[Message], data: bytes) -> Message:
    """Return a message whose arrays of numbers are numpy arrays.

    Raises:
        MessageError: the bytes are not such a message.
    """
    message: Message = cls._decode_arrays(data, 0, len(data), _view)
    return message


def for_json(message: Message) -> dict[str, Any]:
    """Return a message as a JSON value; its numbers may be NaN or infinite."""
    return _plain(message, _json_array)


def for_cbor(message: Message) -> dict[str, Any]:
    """Return a message as a value for CBOR.

    Raises:
        BridgeError: cbor2 is not installed.
    """
    return _plain(message, _cbor_array)


def _plain(message: Message, array: Callable[[Any, str], Any]) -> dict[str, Any]:
    found = {}
    for name, convert in _plan(type(message), array):
        value = getattr(message, name)
        found[name] = value if convert is None else convert(value)
    return found


@lru_cache(2000)
def _plan(cls: type[Message], array: Callable[[Any, str], Any]) -> list[tuple[str, _Convert | None]]:
    return [(name, _converter(cls, kind, array)) for name, kind in zip(cls.__slots__, cls._slot_types, strict=True)]


def _converter(cls: type[Message], kind: str, array: Callable[[Any, str], Any]) -> _Convert | None:
    base, bracket, _ = kind.partition("[")
    if base in cls._classes:
        one: _Convert = lambda value: _plain(value, array)  # noqa: E731 - it has no name of its own
    elif base in ("time", "duration"):
        one = _time
    elif not bracket:
        return None
    else:
        return list if base == "string" else lambda value: array(value, base)
    return (lambda values: [one(value) for value in values]) if bracket else one


def _time(value: Any) -> dict[str, int]:
    return {"secs": value.secs, "nsecs": value.nsecs}


def _json_array(value: Any, base: str) -> Any:
    if base in _BYTES:
        return base64.b64encode(value.data if isinstance(value, np.ndarray) else bytes(value)).decode("ascii")
    return value.tolist() if isinstance(value, np.ndarray) else list(value)


def _cbor_array(value: Any, base: str) -> Any:
    if base in _BYTES:
        return bytes(value)
    if base not in _TAGS:
        return [bool(each) for each in value]
    array = np.asarray(value, _dtype(base))
    return tagged(_TAGS[base], array.tobytes())


def _dtype(base: str) -> str:
    return "int8" if base == "byte" else np.dtype(base).newbyteorder("<").str


def from_client(cls: type[Message], value: Any, now: Time) -> Message:
    """Return a message that a client wrote.

    Args:
        cls: its class.
        value: a JSON object. What it leaves out has its default; a header without a time gets one.
        now: that time.

    Raises:
        MessageError: a value does not fit its field; the text names the field.
    """
    if value is None:
        value = {}
    if not isinstance(value, dict):
        raise MessageError(f"a {cls._type} must be a JSON object")
    message = from_json(cls, _with_nan(cls, value), now)
    if cls._has_header:
        name = cls.__slots__[0]
        given = value.get(name)
        if not given or (isinstance(given, dict) and "stamp" not in given):
            getattr(message, name).stamp = now
    return message


def from_args(cls: type[Message], args: Any, now: Time) -> Message:
    """Return a request or response, from an object, or a list of the values of its fields in order.

    Raises:
        MessageError: a value does not fit its field, or their number is wrong.
    """
    if not isinstance(args, list):
        return from_client(cls, args, now)
    names = cls.__slots__
    if len(args) == 1 and isinstance(args[0], dict) and set(args[0]) <= set(names):
        return from_client(cls, args[0], now)
    if args and len(args) != len(names):
        raise MessageError(f"{cls._type} has {len(names)} fields, not {len(args)}: {', '.join(names)}")
    return from_client(cls, dict(zip(names, args, strict=False)), now)


def _with_nan(cls: type[Message], value: Any) -> Any:
    """Replace null by NaN where a number stands: it is what clients were sent for it."""
    if not isinstance(value, dict):
        return value
    types = dict(zip(cls.__slots__, cls._slot_types, strict=True))
    return {name: _field(cls, types.get(name, ""), inner) for name, inner in value.items()}


def _field(cls: type[Message], kind: str, value: Any) -> Any:
    base, bracket, _ = kind.partition("[")
    if base in _FLOATS:
        if bracket and isinstance(value, list):
            return [math.nan if each is None else each for each in value] if None in value else value
        return math.nan if value is None else value
    nested = cls._classes.get(base)
    if nested is None:
        return value
    if bracket and isinstance(value, list):
        return [_with_nan(nested, each) for each in value]
    return {} if value is None else _with_nan(nested, value)
