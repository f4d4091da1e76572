"""Paths to fields, filters of fields, and messages as rows of numbers."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any

from genpy import Message, TVal

from pyros1.msgs.text import format_message
from pyros1.observe.fields import FieldPath, FieldPathError


def msgevalgen(pattern: str) -> Callable[[Any], Any] | None:
    """Return a function that returns a field of a message.

    Args:
        pattern: the path behind the topic, for example ``/pose/position/x`` or ``/poses[0:2]``.

    Returns:
        The function, which prints an error and returns None for messages without the field. None for an empty path,
        and for a wrong one, after an error was printed.
    """
    try:
        path = FieldPath(pattern)
    except FieldPathError as error:
        print(error, file=sys.stderr)
        return None

    def field(message: Any) -> Any:
        try:
            return path.get(message)[0]
        except FieldPathError as error:
            print(error, file=sys.stderr)
            return None

    return field if pattern.strip("/") else None


def create_field_filter(echo_nostr: bool, echo_noarr: bool) -> Callable[[Any], Iterator[str]]:
    """Return a function that yields the names of a message's fields, without those of texts or of arrays.

    Args:
        echo_nostr: leave out texts.
        echo_noarr: leave out arrays.
    """

    def field_filter(val: Any) -> Iterator[str]:
        for name, kind in zip(val.__slots__, val._slot_types, strict=True):
            is_text = kind == "string" or kind.startswith(("string[", "std_msgs/String"))
            if not (echo_noarr and "[" in kind) and not (echo_nostr and is_text):
                yield name

    return field_filter


class Shown:
    """A message of which strings or arrays are shown by their length only."""

    def __init__(self, message: Any, no_string: bool, no_array: bool) -> None:
        self.message = message
        self.no_string = no_string
        self.no_array = no_array

    def __str__(self) -> str:
        return format_message(self.message, no_string=self.no_string, no_array=self.no_array)

    __repr__ = __str__


def create_value_transform(echo_nostr: bool, echo_noarr: bool) -> Callable[..., Any]:
    """Return a function that replaces strings, arrays or both by their lengths.

    Args:
        echo_nostr: replace strings.
        echo_noarr: replace arrays.

    Returns:
        A function of a message, or of a field's value and its type.
    """

    def value_transform(val: Any, type_information: str | None = None) -> Any:
        if isinstance(val, Message):
            return Shown(val, echo_nostr, echo_noarr)
        if type_information is None:
            return val
        if echo_noarr and "[" in type_information:
            return f"<array type: {type_information[: type_information.rfind('[')]}, length: {len(val)}>"
        if echo_nostr and type_information == "string":
            return f"<string length: {len(val)}>"
        return val

    return value_transform


# Rows ----------------------------------------------------------------------------------------------------------------


def _isstring_type(t: Any) -> bool:
    return t is str or t is bytes


def _leaves(value: Any, field_filter: Any) -> Iterator[Any]:
    if isinstance(value, TVal):
        yield value
    elif isinstance(value, Message):
        for name in value.__slots__ if field_filter is None else list(field_filter(value)):
            yield from _leaves(getattr(value, name), field_filter)
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from _leaves(each, field_filter)
    else:
        yield value


def _sub_str_plot(val: Any, time_offset: Any, field_filter: Any) -> str:
    """Return a message as a row: its values, separated by commas."""
    words = []
    for each in _leaves(val, field_filter):
        if isinstance(each, TVal):
            words.append(str((each - time_offset if time_offset else each).to_nsec()))
        else:
            words.append(str(each))
    return ",".join(words)


def _str_plot(
    val: Any,
    time_offset: Any = None,
    current_time: Any = None,
    field_filter: Any = None,
    type_information: Any = None,
    fixed_numeric_width: Any = None,
    value_transform: Any = None,
) -> str:
    """Return a message as a row with its time in nanoseconds in front, as ``rostopic echo -p`` prints it."""
    import rospy

    row = _sub_str_plot(val, time_offset, field_filter)
    if not isinstance(val, Message):
        return row
    if current_time is not None:
        moment = current_time
    elif getattr(val, "_has_header", False):
        moment = getattr(val, "header").stamp  # noqa: B009
    else:
        moment = rospy.get_rostime()
    if time_offset:
        moment = moment - time_offset
    return f"{moment.to_nsec()},{row}"


def _names(value: Any, before: str, field_filter: Any) -> Iterator[str]:
    if isinstance(value, Message):
        for name in value.__slots__ if field_filter is None else list(field_filter(value)):
            yield from _names(getattr(value, name), f"{before}.{name}", field_filter)
    elif isinstance(value, (list, tuple)):
        for number, each in enumerate(value):
            yield from _names(each, f"{before}{number}", field_filter)
    else:
        yield before


def _sub_str_plot_fields(val: Any, f: str, field_filter: Any) -> str:
    """Return the names of the columns of `_sub_str_plot`."""
    return ",".join(_names(val, f, field_filter))


def _str_plot_fields(val: Any, f: str, field_filter: Any) -> str:
    """Return the names of the columns of `_str_plot`."""
    return f"time,{_sub_str_plot_fields(val, f, field_filter)}"
