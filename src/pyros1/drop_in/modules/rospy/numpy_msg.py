"""Messages whose numeric arrays are numpy arrays (https://wiki.ros.org/rospy_tutorials/Tutorials/numpy)."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy

from pyros1.msgs.array_views import make_genpy_view
from pyros1.msgs.base import MessageType

__all__ = ["numpy_msg"]

_view = make_genpy_view(numpy)


@lru_cache(maxsize=1000)
def numpy_msg(msg_type: Any) -> Any:
    """Return a class of the same type whose received messages have numpy arrays.

    Arrays have one dimension, shape (n,), and the field's number type; they are read-only, since they refer to the
    bytes received. Arrays of uint8 and char are bytes, as in any message. The class can also be passed to Publisher,
    although fields accept numpy arrays with any class.
    """

    def decode(buffer: bytes, start: int, end: int, exact: bool = False) -> Any:
        message: Any = numpy_class.__new__(numpy_class)
        decoded: Any = msg_type._decode_arrays(buffer, start, end, _view, exact)
        for name in msg_type.__slots__:
            setattr(message, name, getattr(decoded, name))
        return message

    def deserialize(self: Any, data: bytes) -> Any:
        decoded: Any = msg_type._decode_arrays(bytes(data), 0, len(data), _view)
        for name in msg_type.__slots__:
            setattr(self, name, getattr(decoded, name))
        return self

    members = {"__slots__": (), "_decode": staticmethod(decode), "deserialize": deserialize}
    numpy_class: Any = MessageType(f"Numpy_{msg_type._type.replace('/', '__')}", (msg_type,), members)
    return numpy_class
