"""Converts numpy values that stock's codecs accept with older versions of numpy: arrays of one element in float fields,
and numpy booleans in integer fields.

Newer versions of numpy no longer convert such values (arrays since NumPy 2.4), but programs written for stock rely on
the conversion. The generated codecs do not check for such values: `retry_with_plain_numbers` is called after a codec
has failed.
"""

from __future__ import annotations

from typing import Any

from pyros1.msgs.base import Message
from pyros1.msgs.check import encoding_error
from pyros1.msgs.generator import fields_of, split_type
from pyros1.msgs.spec import STRUCT_CODES


def retry_with_plain_numbers(cls: type[Message], codec: str, message: Any, error: Exception) -> Any:
    """Retry a codec that failed on a wrong value, with plain numbers in the message, and return its result.

    Args:
        cls: the message's class.
        codec: name of the codec, an attribute of the class.
        message: the message, which is not changed.
        error: the codec's error.

    Raises:
        SerializationError: a value is still wrong; the message names its field.
    """
    plain = _plain_message(cls, message)
    if plain is message:
        raise encoding_error(cls, message, error) from error
    return getattr(cls, codec)(plain)


def _plain_message(cls: type[Message], message: Any) -> Any:
    """Return the message, or a copy with plain numbers if it contains numpy values."""
    changed = {}
    for name, slot_type in fields_of(cls):
        value = getattr(message, name, None)
        base, length = split_type(slot_type)
        code = STRUCT_CODES.get(base, "")
        if length is None:
            plain = _plain_message(cls._classes[base], value) if base in cls._classes else _plain_value(code, value)
        else:
            plain = _plain_array(code, value)
        if plain is not value:
            changed[name] = plain
    if not changed:
        return message
    copy = cls.__new__(cls)
    for name in cls.__slots__:
        setattr(copy, name, changed[name] if name in changed else getattr(message, name, None))
    return copy


def _plain_array(code: str, values: Any) -> Any:
    """Return a list of plain numbers if an array or list contains numpy values. Arrays of messages are
    returned unchanged: the codec of each element retries by itself.
    """
    if not code or isinstance(values, (str, bytes)) or not hasattr(values, "__len__"):
        return values
    if code == "B" and not isinstance(values, (list, tuple)):
        return values
    try:
        elements = list(values)
    except TypeError:  # a numpy array without dimensions
        return values
    plain = [_plain_value(code, value) for value in elements]
    return values if all(map(lambda converted, original: converted is original, plain, elements)) else plain


def _plain_value(code: str, value: Any) -> Any:
    dtype_kind = getattr(getattr(value, "dtype", None), "kind", "")
    if code and code in "fd":
        if dtype_kind not in ("", "c") and hasattr(value, "__len__") and value.size == 1:
            try:
                return float(value.item())
            except (TypeError, ValueError):
                return value
    elif code and dtype_kind == "b" and not hasattr(value, "__len__"):
        return int(value)
    return value
