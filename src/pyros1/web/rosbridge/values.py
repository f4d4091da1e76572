"""Converts messages to CBOR values, and JSON values from clients to messages (no I/O).

In CBOR, an array of numbers is the array's bytes from the message, with a tag that specifies the type of the numbers
(https://datatracker.ietf.org/doc/html/draft-ietf-cbor-array-tags-00). `json_text` describes the form in JSON.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.msgs import Message
from pyros1.msgs.array_views import make_numpy_view
from pyros1.msgs.json_form import from_json
from pyros1.web.rosbridge.frames import LARGE_BYTES, with_cbor_tag

_UINT8_TYPES = ("uint8", "char")
_FLOAT_TYPES = ("float32", "float64")
_CBOR_ARRAYS: dict[str, tuple[int, np.dtype[Any]]] = {
    "uint16": (69, np.dtype("<u2")),
    "uint32": (70, np.dtype("<u4")),
    "uint64": (71, np.dtype("<u8")),
    "int8": (72, np.dtype("i1")),
    "byte": (72, np.dtype("i1")),
    "int16": (77, np.dtype("<i2")),
    "int32": (78, np.dtype("<i4")),
    "int64": (79, np.dtype("<i8")),
    "float32": (85, np.dtype("<f4")),
    "float64": (86, np.dtype("<f8")),
}
"""CBOR tags of arrays of little-endian numbers, and their numpy types."""
_TIME_TYPES = ("time", "duration")
_HEADER_TYPES = ("std_msgs/Header", "roslib/Header")
_Converter = Callable[[Any], Any]
_numpy_view = make_numpy_view(np)


def decode(cls: type[Message], data: bytes) -> Message:
    """Decode a message; its arrays of numbers become numpy arrays.

    Raises:
        MessageError: the bytes are not a message of this class.
    """
    message: Message = cls._decode_arrays(data, 0, len(data), _numpy_view)
    return message


def for_cbor(message: Message, copy: bool = False) -> dict[str, Any]:
    """Return a message as a value to be encoded by `frames.to_cbor`.

    Args:
        message: the message.
        copy: whether large arrays are copied. Otherwise they are memoryviews, which `frames.to_cbor` accepts in dicts
            and tags.

    Raises:
        BridgeError: cbor2 is not installed.
    """
    fields = {}
    for name, convert in _converters(type(message), copy):
        value = getattr(message, name)
        fields[name] = value if convert is None else convert(value)
    return fields


@lru_cache(2000)
def _converters(cls: type[Message], copy: bool) -> list[tuple[str, _Converter | None]]:
    return [
        (name, _converter(cls, field_type, copy))
        for name, field_type in zip(cls.__slots__, cls._slot_types, strict=True)
    ]


def _converter(cls: type[Message], field_type: str, copy: bool) -> _Converter | None:
    base_type, bracket, _ = field_type.partition("[")
    if base_type in cls._classes:
        convert_element: _Converter = partial(for_cbor, copy=copy or bool(bracket))
    elif base_type in _TIME_TYPES:
        convert_element = _time_to_dict
    elif not bracket:
        return None
    else:
        return list if base_type == "string" else lambda value: _cbor_array(value, base_type, copy)
    return (lambda values: [convert_element(value) for value in values]) if bracket else convert_element


@lru_cache(2000)
def is_flat(cls: type[Message]) -> bool:
    """Return whether converting a message takes about the same time whatever its size: its only arrays are arrays of
    numbers, which need no conversion of each element.
    """
    for field_type in cls._slot_types:
        base_type, bracket, _ = field_type.partition("[")
        nested = cls._classes.get(base_type)
        if bracket and (nested is not None or base_type in (*_TIME_TYPES, "string", "bool")):
            return False
        if nested is not None and not is_flat(nested):
            return False
    return True


@lru_cache(2000)
def has_only_bytes(cls: type[Message]) -> bool:
    """Return whether a message's only variable-length arrays are ``uint8[]`` and ``char[]``."""
    for field_type in cls._slot_types:
        base_type, bracket, length = field_type.partition("[")
        nested = cls._classes.get(base_type)
        if bracket and base_type not in _UINT8_TYPES and (nested is not None or length == "]"):
            return False
        if nested is not None and not has_only_bytes(nested):
            return False
    return True


def _time_to_dict(value: Any) -> dict[str, int]:
    return {"secs": value.secs, "nsecs": value.nsecs}


def _cbor_array(value: Any, base_type: str, copy: bool) -> Any:
    if base_type in _UINT8_TYPES:
        return _bytes_of(value, copy) if isinstance(value, np.ndarray) else bytes(value)
    if base_type not in _CBOR_ARRAYS:
        return [bool(each) for each in value]
    tag, numpy_type = _CBOR_ARRAYS[base_type]
    return with_cbor_tag(tag, _bytes_of(np.asarray(value, numpy_type), copy))


def _bytes_of(array: np.ndarray[Any, Any], copy: bool) -> bytes | memoryview:
    return array.tobytes() if copy or array.nbytes <= LARGE_BYTES else array.data.cast("B")


def from_client(cls: type[Message], value: Any, now: Time) -> Message:
    """Return the message that a client has sent as JSON.

    As in rosbridge_suite, each header in the client's message, at any depth, gets the current time unless the client
    has set a valid time.

    Args:
        cls: class of the message.
        value: a JSON object. Missing fields get default values.
        now: the current time.

    Raises:
        MessageError: a value does not fit its field; the error message names the field.
    """
    if value is None:
        value = {}
    if not isinstance(value, dict):
        raise MessageError(f"a {cls._type} must be a JSON object")
    return from_json(cls, _prepare(cls, value, now), now)


def from_args(cls: type[Message], args: Any, now: Time) -> Message:
    """Return a service request or response that a client has sent as an object, or as a list of the values of its first
    fields.

    As in rosbridge_suite, any other value is treated as an empty object, and surplus values in a list are ignored.

    Raises:
        MessageError: a value does not fit its field.
    """
    if isinstance(args, list):
        names = cls.__slots__
        if len(args) == 1 and isinstance(args[0], dict) and set(args[0]) <= set(names):
            args = args[0]
        else:
            args = dict(zip(names, args, strict=False))
    return from_client(cls, args if isinstance(args, dict) else {}, now)


def _prepare(cls: type[Message], value: Any, now: Time) -> Any:
    """Convert a JSON object from a client to the form that `from_json` expects."""
    if not isinstance(value, dict):
        return value
    types = dict(zip(cls.__slots__, cls._slot_types, strict=True))
    fields = {name: _prepare_field(cls, types.get(name, ""), child, now) for name, child in value.items()}
    if cls._type in _HEADER_TYPES:
        fields["stamp"] = {"secs": now.secs, "nsecs": now.nsecs} | _time_fields(value.get("stamp"))
    return fields


def _prepare_field(cls: type[Message], field_type: str, value: Any, now: Time) -> Any:
    base_type, bracket, _ = field_type.partition("[")
    if bracket and isinstance(value, list) and (base_type in _TIME_TYPES or base_type in cls._classes or None in value):
        return [_prepare_field(cls, base_type, each, now) for each in value]
    if bracket and base_type in _UINT8_TYPES and isinstance(value, str):
        return _decode_base64(value)
    if base_type in _FLOAT_TYPES:  # clients get null for NaN, and send it back
        return math.nan if value is None else value
    if base_type in _TIME_TYPES and not bracket:
        return value if base_type == "time" and value == "now" else _time_fields(value)
    nested = cls._classes.get(base_type)
    if nested is None or bracket:
        return value
    return _prepare(nested, {} if value is None else value, now)


def _time_fields(value: Any) -> dict[str, Any]:
    return {name: value[name] for name in ("secs", "nsecs") if name in value} if isinstance(value, dict) else {}


def _decode_base64(text: str) -> Any:
    """Return the bytes of a base64 string, ignoring line breaks; return the string itself if it is not base64."""
    try:
        return base64.b64decode(text)
    except ValueError:
        return text
