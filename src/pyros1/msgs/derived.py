"""Message classes that programs derive from others: they are created and written like those of genpy.

The generated decoder makes objects of the very class that a definition gave, and the encoder reads their fields.
A derived class has a constructor, and perhaps a ``deserialize`` and a ``serialize``, which the program wants called.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import DeserializationError
from pyros1.msgs.base import Message, message_class


def derive(cls: Any) -> None:
    """Set the codec functions of a class that a program has just derived; those that it defines itself stay."""
    members = vars(cls)
    if members.get("_slot_types") == super(cls, cls)._slot_types and "_slot_types" in members:
        del cls._slot_types  # repeated, as rospy's numpy_msg does; the definition's class is the base
    if "_decode" not in members:
        cls._decode = staticmethod(make_decode(cls))
        cls._wants_whole = cls.deserialize is not Message.deserialize
    if cls.serialize is not Message.serialize and message_class(cls) is not cls:
        cls._encode = staticmethod(encode)
        cls._encode_frame = staticmethod(encode_frame)
        cls._copy = staticmethod(make_copy(cls))


def make_decode(cls: Any) -> Callable[..., Any]:
    """Return a decoder that asks objects of the class to read."""

    def decode(buffer: bytes, start: int, end: int, exact: bool = False) -> Any:
        try:
            return cls().deserialize(buffer[start:end])
        except DeserializationError:
            raise
        except Exception as error:
            raise DeserializationError(cls._type, 0, f"{type(error).__name__} in {cls.__name__}: {error}") from error

    return decode


def encode(message: Any) -> bytes:
    """Return the body written by a message."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def encode_frame(message: Any) -> bytes:
    """Return the same with its length before it."""
    body = encode(message)
    return len(body).to_bytes(4, "little") + body


def make_copy(cls: Any) -> Callable[[Any], Any]:
    """Return the function that makes a message of the class of the definition from what a message writes."""
    base = message_class(cls)

    def copy(message: Any) -> Any:
        body = encode(message)
        return base._decode(body, 0, len(body))

    return copy
