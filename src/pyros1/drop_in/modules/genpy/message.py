"""Messages: base class, exceptions, texts and values from lists and mappings."""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import DeserializationError, SerializationError
from pyros1.ground.errors import MessageError as MessageException
from pyros1.msgs import Message
from pyros1.msgs.fill import fill_message
from pyros1.msgs.text import format_message

__all__ = ["DeserializationError", "Message", "MessageException", "SerializationError"]


def fill_message_args(msg: Message, msg_args: Any, keys: Any = None) -> None:
    """Set the fields of a message from a list of all values, or a mapping of some."""
    args = (
        msg_args[0] if isinstance(msg_args, list) and len(msg_args) == 1 and isinstance(msg_args[0], dict) else msg_args
    )
    fill_message(msg, args, (keys or {}).get("now"))


def strify_message(val: Any, indent: str = "", time_offset: Any = None, current_time: Any = None, **_: Any) -> str:
    """Return a message as text, as ``rostopic echo`` prints it."""
    return format_message(val) if isinstance(val, Message) else str(val)


def get_printable_message_args(msg: Message, buff: Any = None, prefix: str = "") -> str:
    """Return the names of a message's fields, those of messages in it with their path."""
    names = []
    for name, kind in zip(msg.__slots__, msg._slot_types, strict=True):
        value = getattr(msg, name)
        if isinstance(value, Message) and "[" not in kind:
            names.append(get_printable_message_args(value, None, prefix + name + "."))
        else:
            names.append(prefix + name)
    return " ".join(names)
