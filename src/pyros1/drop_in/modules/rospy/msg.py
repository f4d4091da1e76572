"""Messages of any type, and functions that create messages from arguments."""

from __future__ import annotations

import struct
from typing import Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.ground.errors import DeserializationError
from pyros1.msgs import AnyMsg, Message
from rospy.exceptions import ROSException

__all__ = ["AnyMsg", "Message", "args_kwds_to_message", "deserialize_messages", "serialize_message"]


def args_kwds_to_message(data_class: type[Any], args: tuple[Any, ...], kwds: dict[str, Any]) -> Any:
    """Create a message from the arguments of ``publish``.

    Args:
        data_class: the message class.
        args: a message, or the values of all fields.
        kwds: the values of some fields by name.

    Raises:
        TypeError: positional and named values are mixed, or the message is of another type.
        AttributeError: there is no field with that name.
    """
    if args and kwds:
        raise TypeError("publish() can be called with arguments or keywords, but not both.")
    if kwds:
        return data_class(**kwds)
    if len(args) != 1:
        return data_class(*args)
    value = args[0]
    md5sum = getattr(value, "_md5sum", None)
    if md5sum is None or isinstance(value, type):
        return data_class(value)
    if md5sum == data_class._md5sum or isinstance(value, AnyMsg):
        return value
    if data_class._slot_types[:1] == [value._type]:
        return data_class(value)  # the only field; if there are several, the error names the missing ones
    raise TypeError(f"expected [{data_class._slot_types[0] if data_class._slot_types else ''}] but got [{value._type}]")


class _ByteCollector:
    """Collects the bytes that a message writes."""

    def __init__(self) -> None:
        self.data = bytearray()

    def write(self, data: bytes) -> None:
        self.data += data


def serialize_message(b: Any, seq: int, msg: Any) -> None:
    """Write a message, preceded by its length.

    Args:
        b: a writable binary file, positioned at its end.
        seq: sequence number for the header, if the message has one.
        msg: the message.
    """
    if getattr(msg.__class__, "_has_header", False):
        msg.header.seq = seq
        if msg.header.frame_id is None:
            msg.header.frame_id = "0"
    collector = _ByteCollector()
    msg.serialize(collector)
    b.write(struct.pack("<I", len(collector.data)) + bytes(collector.data))


def deserialize_messages(
    b: Any,
    msg_queue: list[Any],
    data_class: type[Any],
    queue_size: int | None = None,
    max_msgs: int | None = None,
    start: int = 0,
) -> None:
    """Read length-prefixed messages, and keep the remaining bytes in the buffer.

    Args:
        b: a readable and writable binary file, filled up to its position.
        msg_queue: a list to which the messages are added.
        data_class: the message class.
        queue_size: maximum number of messages to keep; if there are more, the last ones are kept.
        max_msgs: maximum number of messages to read.
        start: position of the first message.

    Raises:
        DeserializationError: a message cannot be read, or there is no buffer, queue or class.
    """
    try:
        _read(b, msg_queue, data_class, queue_size, max_msgs, start)
    except Exception as error:
        raise DeserializationError(f"cannot deserialize: {error}") from error


def _read(
    b: Any, msg_queue: list[Any], data_class: type[Any], queue_size: int | None, max_msgs: int | None, start: int
) -> None:
    end = b.tell()
    if end - start < 4:
        return
    b.seek(start)
    data = b.read(end - start)
    if len(data) < end - start:
        raise ValueError("the buffer is not filled up to its position")
    position = 0
    bodies: list[bytes] = []
    while len(data) - position >= 4 and not (max_msgs and len(bodies) >= max_msgs):
        (size,) = struct.unpack_from("<I", data, position)
        if len(data) - position - 4 < size:
            break
        bodies.append(data[position + 4 : position + 4 + size])
        position += 4 + size
    if queue_size is not None:
        bodies = bodies[-queue_size:]
    for body in bodies:
        msg_queue.append(data_class().deserialize(body))
    if queue_size is not None:
        del msg_queue[:-queue_size]
    if position:
        b.seek(start)
        b.write(data[position:])
        b.truncate()


def _serialize(self: AnyMsg, buff: Any) -> None:
    """Write the bytes of a message to a file.

    Raises:
        ROSException: there are no bytes.
    """
    if self._buff is None:
        raise ROSException("AnyMsg is not initialized")
    buff.write(self._buff)


AnyMsg.serialize = _serialize  # type: ignore[method-assign]  # raises stock's error

__getattr__, __dir__ = _module_hooks(__name__)
