"""Helpers of `rosbag.bag.Bag` for reading and writing messages."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from typing import Any

from genpy.rostime import Time as AnyTime

from pyros1.bag.format.records import FIRST_LINE_PATTERN
from pyros1.msgs import Message
from pyros1.msgs.base import message_class
from rosbag._types import BagMessage, BagMessageWithConnectionHeader, ROSBagException


def make_bag_message(info: Any, message: Any, stamp: Any, with_header: bool) -> Any:
    """Return a message in the form that `read_messages` yields."""
    if with_header:
        return BagMessageWithConnectionHeader(info.topic, message, stamp, info.header)
    return BagMessage(info.topic, message, stamp)


def to_nanoseconds(time: Any) -> int | None:
    """Return a time in nanoseconds; if it is not a time, raise TypeError, as a comparison would."""
    if time is None:
        return None
    if not isinstance(time, AnyTime):
        raise TypeError(f"'<' not supported between instances of 'Time' and '{type(time).__name__}'")
    nanoseconds: int = time.to_nsec()
    return nanoseconds


def find_decoder(cls: Any) -> Callable[[bytes, int, int], Any]:
    """Return the function that decodes messages of a class: pyros1's, or one set by the program."""
    class_decoder = getattr(cls, "_decode", None)
    return class_decoder if class_decoder is not None else lambda data, start, end: cls().deserialize(data[start:end])


def find_encoder(cls: Any) -> Callable[[Any], bytes]:
    """Return the function that encodes messages of a class: pyros1's, or the class's own ``serialize``."""
    if getattr(cls, "serialize", None) is Message.serialize:
        our_class: Any = message_class(cls)
        encode: Callable[[Any], bytes] = our_class._encode
        return encode

    def serialize(message: Any) -> bytes:
        buffer = io.BytesIO()
        message.serialize(buffer)
        return buffer.getvalue()

    return serialize


def header_fields(topic: str, type_name: str, md5sum: str, cls: Any) -> dict[str, str]:
    """Return the connection header of a topic; raise ROSBagException if ``cls`` is None and the type is unknown."""
    if cls is None:
        from roslib.message import get_message_class

        cls = get_message_class(type_name)
        if cls is None:
            raise ROSBagException(f"cannot locate message class and no message class provided for [{type_name}]")
    if md5sum not in (cls._md5sum, "*"):
        print(f"WARNING: md5sum of loaded type [{type_name}] does not match that specified", file=sys.stderr)
    return {"topic": topic, "type": type_name, "md5sum": md5sum, "message_definition": cls._full_text}


def read_version(file: Any) -> int:
    """Return the version from a bag's first line; raise ROSBagException if the file is not a bag."""
    file.seek(0)
    line = file.read(64)
    file.seek(0)
    if not line:
        raise ROSBagException("empty file")
    match = FIRST_LINE_PATTERN.match(line)
    if match is None:
        raise ROSBagException("This does not appear to be a bag file")
    major, minor = map(int, match.groups())
    return 100 * major + minor
