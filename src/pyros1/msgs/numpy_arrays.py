"""Numeric arrays of a message as numpy arrays (rospy's ``numpy_msg``, https://wiki.ros.org/rospy_tutorials/Tutorials/numpy)."""

from __future__ import annotations

from typing import Any, TypeVar

from pyros1.msgs.base import Message, message_class
from pyros1.msgs.spec import STRUCT_CODES

_M = TypeVar("_M", bound=Message)


def to_numpy(message: _M, numpy: Any) -> _M:
    """Replace the numeric arrays in a decoded message, nested ones too, by numpy arrays; returns the message.

    Args:
        message: a message fresh from decoding.
        numpy: the numpy module.
    """
    cls = message_class(type(message))
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        base, bracket, _ = slot_type.partition("[")
        value = getattr(message, name)
        if base in cls._classes:
            for item in value if bracket else [value]:
                to_numpy(item, numpy)
        elif bracket and base in STRUCT_CODES:
            code = "?" if base == "bool" else STRUCT_CODES[base]
            dtype = numpy.dtype("<" + code)
            array = numpy.frombuffer(value, dtype) if isinstance(value, bytes) else numpy.array(value, dtype)
            setattr(message, name, array)
    return message
