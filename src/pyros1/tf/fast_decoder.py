"""Transforms of received tf2_msgs/TFMessage as tuples, for listeners: no message objects are created. Pure.

A message with 20 transforms has 141 objects; a buffer needs only the numbers of 20 poses.
"""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct
from struct import error as StructError
from typing import Any, cast

from pyros1.msgs.base import Message, MessageType
from pyros1.tf.rotation import Transform

Row = tuple[str, str, int, Transform]
"""Parent, child, time in ns, and the pose of the child in the parent."""

_COUNT = Struct("<I").unpack_from
_HEAD = Struct("<4I").unpack_from  # number, seconds, nanoseconds, length of the parent's name
_NUMBERS = Struct("<7d").unpack_from
_NS = 1_000_000_000
MAX_NAMES = 10_000
"""Maximum number of cached names; a sender that keeps inventing new ones must not fill the memory."""


class ReceivedTransforms:
    """Transforms that a listener gets in place of a message.

    Attributes:
        rows: its transforms.
    """

    __slots__ = ("_connection_header", "rows")

    def __init__(self, rows: list[Row]) -> None:
        self.rows = rows
        self._connection_header: dict[str, str] | None = None


def received_class(tf_message: type[Any]) -> type[Message]:
    """Return a class to subscribe with: its messages are `ReceivedTransforms`, or of ``tf_message`` if unusual.

    Args:
        tf_message: tf2_msgs/TFMessage.
    """
    members = {"__slots__": (), "_decode": staticmethod(decoder(tf_message._decode))}
    return cast(type[Message], MessageType(tf_message.__name__, (tf_message,), members))


def decoder(decode_message: Callable[..., Any]) -> Callable[..., Any]:
    """Return a decoder of messages, with the same arguments as those of message classes.

    Args:
        decode_message: the usual decoder; it gets incomplete messages or ones with non-UTF-8 names, to report them.
    """
    names: dict[bytes, str] = {}

    def decode(buffer: bytes, start: int, end: int, exact: bool = False) -> Any:
        rows: list[Row] = []
        try:
            (count,) = _COUNT(buffer, start)
            at = start + 4
            for _ in range(count):
                _, secs, nsecs, length = _HEAD(buffer, at)
                begin = at + 16
                at = begin + length
                parent = buffer[begin:at]
                (length,) = _COUNT(buffer, at)
                begin = at + 4
                at = begin + length
                child = buffer[begin:at]
                numbers = _NUMBERS(buffer, at)
                at += 56
                if at > end:
                    break
                try:
                    rows.append((names[parent], names[child], secs * _NS + nsecs, numbers))
                except KeyError:
                    if len(names) >= MAX_NAMES:
                        names.clear()
                    # /tf_static is received in another thread: a cache that it clears must not be looked up again here.
                    names[parent] = above = parent.decode()
                    names[child] = below = child.decode()
                    rows.append((above, below, secs * _NS + nsecs, numbers))
        except (StructError, UnicodeDecodeError):
            return decode_message(buffer, start, end, exact)
        return (
            ReceivedTransforms(rows)
            if at == end or (at < end and not exact)
            else decode_message(buffer, start, end, exact)
        )

    return decode
