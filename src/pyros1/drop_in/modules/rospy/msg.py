"""Messages of any type, and what makes messages of arguments."""

from __future__ import annotations

from typing import Any

from pyros1.msgs import AnyMsg, Message

__all__ = ["AnyMsg", "Message", "args_kwds_to_message"]


def args_kwds_to_message(data_class: type[Any], args: tuple[Any, ...], kwds: dict[str, Any]) -> Any:
    """Return the message that the arguments of ``publish`` stand for.

    Raises:
        TypeError: positional and named values are mixed, or the message is of another type.
    """
    if args and kwds:
        raise TypeError("publish() can be called with arguments or keywords, but not both.")
    if kwds:
        return data_class(**kwds)
    if len(args) == 1:
        given = args[0]
        md5sum = getattr(given, "_md5sum", None)
        if isinstance(given, AnyMsg) or (isinstance(given, Message) and md5sum == data_class._md5sum):
            return given
        if isinstance(given, Message) and (
            len(data_class._slot_types) != 1 or given._type != data_class._slot_types[0]
        ):
            raise TypeError(f"expected [{data_class._slot_types}] but got [{given._slot_types}]")
    return data_class(*args)


def serialize_message(b: Any, seq: int, msg: Any) -> None:
    """Write a message with its length in front; a header gets the sequence number."""
    import struct

    if getattr(msg.__class__, "_has_header", False):
        msg.header.seq = seq
    body = bytearray()

    class Buffer:
        def write(self, data: bytes) -> None:
            body.extend(data)

    msg.serialize(Buffer())
    b.write(struct.pack("<I", len(body)) + bytes(body))
