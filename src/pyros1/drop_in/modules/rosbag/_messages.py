"""Helpers with which `rosbag.bag.Bag` reads and writes messages."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from typing import Any

from genpy.rostime import Time as AnyTime

from pyros1.bag.format.records import FIRST_LINE_PATTERN
from pyros1.msgs import Message
from pyros1.msgs.base import message_class
from rosbag._parts import BagMessage, BagMessageWithConnectionHeader, ROSBagException


def result(info: Any, message: Any, stamp: Any, headers: bool) -> Any:
    """Return a message in the form that `read_messages` yields."""
    if headers:
        return BagMessageWithConnectionHeader(info.topic, message, stamp, info.header)
    return BagMessage(info.topic, message, stamp)


def limit(time: Any) -> int | None:
    """Return a time in nanoseconds; raise TypeError, as comparisons do, if it is not a time."""
    if time is None:
        return None
    if not isinstance(time, AnyTime):
        raise TypeError(f"'<' not supported between instances of 'Time' and '{type(time).__name__}'")
    nanoseconds: int = time.to_nsec()
    return nanoseconds


def decoder(cls: Any) -> Callable[[bytes, int, int], Any]:
    """Return the function that decodes messages of a class: that of pyros1, or a function set by the program."""
    own = getattr(cls, "_decode", None)
    return own if own is not None else lambda data, start, end: cls().deserialize(data[start:end])


def encoder(cls: Any) -> Callable[[Any], bytes]:
    """Return the function that encodes messages of a class: that of pyros1, or the class's own ``serialize``."""
    if getattr(cls, "serialize", None) is Message.serialize:
        made: Any = message_class(cls)
        encode: Callable[[Any], bytes] = made._encode
        return encode

    def written(message: Any) -> bytes:
        buffer = io.BytesIO()
        message.serialize(buffer)
        return buffer.getvalue()

    return written


def header_fields(topic: str, kind: str, md5sum: str, cls: Any) -> dict[str, str]:
    """Return the connection header of a topic; raise ROSBagException if the class is required but unknown."""
    if cls is None:
        from roslib.message import get_message_class

        cls = get_message_class(kind)
        if cls is None:
            raise ROSBagException(f"cannot locate message class and no message class provided for [{kind}]")
    if md5sum not in (cls._md5sum, "*"):
        print(f"WARNING: md5sum of loaded type [{kind}] does not match that specified", file=sys.stderr)
    return {"topic": topic, "type": kind, "md5sum": md5sum, "message_definition": cls._full_text}


def version_of(file: Any) -> int:
    """Return the version from a bag's first line; raise ROSBagException if the file is not a bag."""
    file.seek(0)
    line = file.read(64)
    file.seek(0)
    if not line:
        raise ROSBagException("empty file")
    found = FIRST_LINE_PATTERN.match(line)
    if found is None:
        raise ROSBagException("This does not appear to be a bag file")
    major, minor = map(int, found.groups())
    return 100 * major + minor
