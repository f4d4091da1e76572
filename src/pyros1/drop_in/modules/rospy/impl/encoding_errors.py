"""Converts pyros1's errors for messages that cannot be encoded to the errors that stock raises."""

from __future__ import annotations

from pyros1.ground.errors import SerializationError
from rospy.exceptions import ROSSerializationException


def stock_error_for(error: SerializationError) -> Exception:
    """Return the error that stock's publishers raise.

    In stock ROS, a value of a completely different type than its field, such as bytes instead of a string or None
    instead of a message, causes an AttributeError. A string that cannot be encoded as UTF-8 causes a
    UnicodeEncodeError. Programs catch these errors, so pyros1 raises them, too, chained to its own error, which
    names the field.
    """
    cause: BaseException | None = error
    while isinstance(cause, SerializationError):
        if isinstance(cause, OverflowError):  # the number is too large for a float field
            return OverflowError(str(error))
        cause = cause.__cause__ or cause.__context__
    if isinstance(cause, AttributeError) and (cause.name != "encode" or hasattr(cause.obj, "__len__")):
        return AttributeError(*cause.args)  # stock calls len() on a string first
    if isinstance(cause, TypeError) and "'encode' for 'str'" in str(cause) and "'bytes'" in str(cause):  # in a str[]
        return AttributeError("'bytes' object has no attribute 'encode'")
    if isinstance(cause, UnicodeEncodeError):
        return UnicodeEncodeError(*cause.args)
    return ROSSerializationException(str(error))


def fill_in_frame_id(message: object) -> bool:
    """Set the ``frame_id`` of a message's header to "0" if it is None, as in stock ROS; return whether it was None."""
    header = getattr(message, "header", None) if getattr(type(message), "_has_header", False) else None
    if header is None or getattr(header, "frame_id", "") is not None:
        return False
    header.frame_id = "0"
    return True
