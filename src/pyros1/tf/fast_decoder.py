"""Decodes tf2_msgs/TFMessage to tuples, for listeners, without creating message objects. Does no I/O.

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

_unpack_count = Struct("<I").unpack_from
_unpack_header = Struct("<4I").unpack_from  # sequence number, seconds, nanoseconds, length of the parent's name
_unpack_transform = Struct("<7d").unpack_from
_NS_PER_S = 1_000_000_000
MAX_CACHED_NAMES = 10_000
"""Maximum number of cached names: a sender that keeps inventing new ones must not exhaust memory."""


class ReceivedTransforms:
    """The transforms of one message, which a listener receives instead of a message object.

    Attributes:
        rows: the message's transforms.
    """

    __slots__ = ("_connection_header", "rows")

    def __init__(self, rows: list[Row]) -> None:
        self.rows = rows
        self._connection_header: dict[str, str] | None = None


def make_subscription_class(message_class: type[Any]) -> type[Message]:
    """Return a class to subscribe with, whose decoder returns `ReceivedTransforms`; in unusual cases, the decoder
    returns an object of ``message_class``, or raises the errors of that class's decoder.

    Args:
        message_class: the class of tf2_msgs/TFMessage.
    """
    members = {"__slots__": (), "_decode": staticmethod(make_decoder(message_class._decode))}
    return cast(type[Message], MessageType(message_class.__name__, (message_class,), members))


def make_decoder(decode_message: Callable[..., Any]) -> Callable[..., Any]:
    """Return a decoder that takes the same arguments as ``decode_message``, but returns `ReceivedTransforms`.

    Args:
        decode_message: the message class's decoder, which handles incomplete messages and names that are not UTF-8.
    """
    names: dict[bytes, str] = {}

    def decode(buffer: bytes, start: int, end: int, exact: bool = False) -> Any:
        rows: list[Row] = []
        try:
            (count,) = _unpack_count(buffer, start)
            position = start + 4
            for _ in range(count):
                _, secs, nsecs, length = _unpack_header(buffer, position)
                begin = position + 16
                position = begin + length
                parent = buffer[begin:position]
                (length,) = _unpack_count(buffer, position)
                begin = position + 4
                position = begin + length
                child = buffer[begin:position]
                numbers = _unpack_transform(buffer, position)
                position += 56
                if position > end:
                    break
                try:
                    rows.append((names[parent], names[child], secs * _NS_PER_S + nsecs, numbers))
                except KeyError:
                    if len(names) >= MAX_CACHED_NAMES:
                        names.clear()
                    # /tf_static is received in another thread, which may clear the cache, so the names just added may
                    # already be gone.
                    names[parent] = parent_name = parent.decode()
                    names[child] = child_name = child.decode()
                    rows.append((parent_name, child_name, secs * _NS_PER_S + nsecs, numbers))
        except (StructError, UnicodeDecodeError):
            return decode_message(buffer, start, end, exact)
        return (
            ReceivedTransforms(rows)
            if position == end or (position < end and not exact)
            else decode_message(buffer, start, end, exact)
        )

    return decode
