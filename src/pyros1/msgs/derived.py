"""Codecs for message classes that programs derive from other message classes; the behaviour is that of genpy.

The generated decoder creates objects of exactly the class made from the definition, and the encoder reads their fields.
For a derived class, its constructor must be called, and also its ``deserialize`` and ``serialize`` if it has them.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import DeserializationError
from pyros1.msgs.base import Message, message_class


def set_codec_functions(cls: Any) -> None:
    """Set the codec functions of a class that a program has just derived, except for functions that the class defines
    itself.
    """
    members = vars(cls)
    if members.get("_slot_types") == super(cls, cls)._slot_types and "_slot_types" in members:
        del cls._slot_types  # rospy's numpy_msg repeats it, but only the class made from the definition may have it
    if "_decode" not in members:
        cls._decode = staticmethod(make_decode(cls))
        cls._has_own_deserialize = cls.deserialize is not Message.deserialize
    if cls.serialize is not Message.serialize and message_class(cls) is not cls:
        cls._encode = staticmethod(encode)
        cls._encode_frame = staticmethod(encode_frame)
        cls._copy = staticmethod(make_copy(cls))


def make_decode(cls: Any) -> Callable[..., Any]:
    """Return a decoder that creates an object of the class and calls its ``deserialize``."""

    def decode(buffer: bytes, start: int, end: int, exact: bool = False) -> Any:
        try:
            return cls().deserialize(buffer[start:end])
        except DeserializationError:
            raise
        except Exception as error:
            raise DeserializationError(cls._type, 0, f"{type(error).__name__} in {cls.__name__}: {error}") from error

    return decode


def encode(message: Any) -> bytes:
    """Return the body that a message's ``serialize`` method writes."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def encode_frame(message: Any) -> bytes:
    """Return the body that a message's ``serialize`` method writes, preceded by the body's length."""
    body = encode(message)
    return len(body).to_bytes(4, "little") + body


def make_copy(cls: Any) -> Callable[[Any], Any]:
    """Return a function that copies a message: it calls the message's ``serialize`` method, and decodes the result with
    the class made from the definition.
    """
    base = message_class(cls)

    def copy(message: Any) -> Any:
        body = encode(message)
        return base._decode(body, 0, len(body))

    return copy
