"""Decodes tf2_msgs/TFMessage to tuples, for listeners, without creating message objects. Pure.

A message with 20 transforms consists of 141 objects; a buffer needs only the numbers of 20 poses.
"""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct
from struct import error as StructError
from typing import Any, cast

from pyros1.msgs.base import Message, MessageType
from pyros1.tf.rotation import Transform

Row = tuple[str, str, int, Transform]
"""(parent, child, time in ns, pose of the child in the parent)."""

_COUNT = Struct("<I").unpack_from
_HEAD = Struct("<4I").unpack_from  # sequence number, seconds, nanoseconds, length of the parent's name
_NUMBERS = Struct("<7d").unpack_from
_NS = 1_000_000_000
MAX_NAMES = 10_000
"""Maximum number of cached names, since a sender that keeps inventing new ones must not exhaust memory."""


class ReceivedTransforms:
    """The transforms that a listener receives instead of a message.

    Attributes:
        rows: the transforms in the message.
    """

    __slots__ = ("_connection_header", "rows")

    def __init__(self, rows: list[Row]) -> None:
        self.rows = rows
        self._connection_header: dict[str, str] | None = None


def received_class(tf_message: type[Any]) -> type[Message]:
    """Return a class to subscribe with, which decodes to `ReceivedTransforms`, or to ``tf_message`` in unusual cases.

    Args:
        tf_message: tf2_msgs/TFMessage.
    """
    members = {"__slots__": (), "_decode": staticmethod(make_decoder(tf_message._decode))}
    return cast(type[Message], MessageType(tf_message.__name__, (tf_message,), members))


def make_decoder(decode_message: Callable[..., Any]) -> Callable[..., Any]:
    """Return a decoder with the same arguments as those of message classes.

    Args:
        decode_message: the regular decoder, which is called for incomplete messages and for non-UTF-8 names, to report
            them.
    """
    names: dict[bytes, str] = {}

    def decode(buffer: bytes, start: int, end: int, exact: bool = False) -> Any:
        rows: list[Row] = []
        try:
            (count,) = _COUNT(buffer, start)
            position = start + 4
            for _ in range(count):
                _, secs, nsecs, length = _HEAD(buffer, position)
                begin = position + 16
                position = begin + length
                parent = buffer[begin:position]
                (length,) = _COUNT(buffer, position)
                begin = position + 4
                position = begin + length
                child = buffer[begin:position]
                numbers = _NUMBERS(buffer, position)
                position += 56
                if position > end:
                    break
                try:
                    rows.append((names[parent], names[child], secs * _NS + nsecs, numbers))
                except KeyError:
                    if len(names) >= MAX_NAMES:
                        names.clear()
                    # /tf_static is received in another thread, which may clear the cache, so it must not be accessed
                    # again here.
                    names[parent] = parent_name = parent.decode()
                    names[child] = child_name = child.decode()
                    rows.append((parent_name, child_name, secs * _NS + nsecs, numbers))
        except (StructError, UnicodeDecodeError):
            return decode_message(buffer, start, end, exact)
        return (
            ReceivedTransforms(rows)
            if position == end or (position < end and not exact)
            else decode_message(buffer, start, end, exact)
        )

    return decode
