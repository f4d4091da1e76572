"""The base class of messages, their exceptions, and functions that fill, check and print messages."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from genpy.base import is_simple
from genpy.rostime import Duration, Time, TVal
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.drop_in.unicode_errors import RosMsgUnicodeErrors
from pyros1.ground.errors import DeserializationError, SerializationError
from pyros1.ground.errors import MessageError as MessageException
from pyros1.msgs import Message
from pyros1.msgs.check import check_value
from pyros1.msgs.fill import fill_message
from pyros1.msgs.spec import is_type_name

struct_I = struct.Struct("<I")
_TIME_CLASSES = {"time": Time, "duration": Duration}

__getattr__ = module_getattr(__name__)


def isstring(s: object) -> bool:
    """Return whether a value is a str."""
    return isinstance(s, str)


def fill_message_args(msg: Any, msg_args: Any, keys: Mapping[str, Any] | None = None) -> None:
    """Set the fields of a message.

    Args:
        msg: the message.
        msg_args: a list of all values, a mapping with some of the values, or a list containing one such mapping.
        keys: words that stand for times and headers in ``msg_args``, with their values.

    Raises:
        MessageException: a value does not fit its field.
        ValueError: ``msg_args`` has the wrong type.
    """
    if not isinstance(msg, (Message, TVal)):
        raise ValueError(f"msg must be a Message or time, not {type(msg).__name__}")
    if not isinstance(msg_args, (dict, list, type(None))):
        raise ValueError(f"invalid msg_args type: {msg_args}")
    fill_message(msg, msg_args, keys=keys)


def strify_message(
    val: Any,
    indent: str = "",
    time_offset: Time | None = None,
    current_time: Time | None = None,
    field_filter: Any = None,
    fixed_numeric_width: int | None = None,
) -> str:
    """Return a message, or a value from one, as text similar to YAML, as ``rostopic echo`` prints it.

    Args:
        val: the value.
        indent: prefix of each line.
        time_offset: this time is subtracted from all times shown.
        current_time: has no effect.
        field_filter: called with each message; returns the names of the fields to show. None to show all fields.
        fixed_numeric_width: number of characters of each number; None for as many as needed.
    """
    from pyros1.msgs.text import format_message

    return format_message(
        val, indent=indent, time_offset=time_offset, field_filter=field_filter, width=fixed_numeric_width
    )


def get_printable_message_args(msg: Message, buff: Any = None, prefix: str = "") -> str:
    """Return the names of a message's fields; nested fields are prefixed with their path.

    Args:
        msg: the message.
        buff: a text buffer to which the names are appended, and whose whole text is returned; None for no buffer.
        prefix: path of the message itself, ending with a dot.
    """
    text = "".join(_printable_names(msg, prefix))
    if buff is not None:
        buff.write(text)
        text = buff.getvalue()
    return text.rstrip()


def _printable_names(msg: Any, prefix: str) -> list[str]:
    names: list[str] = []
    for name in msg.__slots__:
        value = getattr(msg, name)
        names += _printable_names(value, f"{prefix}{name}.") if isinstance(value, Message) else [f"{prefix}{name} "]
    return names


def check_type(field_name: str, field_type: str, field_val: Any) -> None:
    """Check a field's value.

    Args:
        field_name: name of the field, for the error.
        field_type: its type, as in ``_slot_types``.
        field_val: the value.

    Raises:
        SerializationError: the value does not fit the type.
    """
    check_value(field_name, field_type, field_val, get_message_class)


def get_message_class(message_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of a message type; None if there is no definition.

    Args:
        message_type: ``package/Type``; also ``Header``, ``time`` and ``duration``.
        reload_on_error: has no effect.

    Raises:
        ValueError: the name has no package.
    """
    name = "std_msgs/Header" if message_type == "Header" else message_type
    return _TIME_CLASSES.get(name) or _find_class(name, "msg")


def get_service_class(service_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of a service type; see :func:`get_message_class` for the arguments and errors."""
    return _find_class(service_type, "srv")


def _find_class(name: str, kind: str) -> Any:
    if "/" not in name:
        raise ValueError(f"message type is missing package name: {name!s}")
    if not is_type_name(name):
        raise ValueError(f"invalid name [{name}]")
    package, _, short = name.partition("/")
    try:  # the module that programs import, which may come from a catkin workspace
        return getattr(import_module(f"{package}.{kind}"), short, None)
    except (ImportError, MessageException):
        return None
