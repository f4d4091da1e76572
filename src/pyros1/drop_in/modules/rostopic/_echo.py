"""Extracts fields of messages, and prints messages as they arrive."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any

import rospy
from genpy import Message
from genpy.message import strify_message

from pyros1.bag.export.tables import Table
from pyros1.msgs.text import format_message
from pyros1.observe.fields import FieldPath, FieldPathError

_CLEAR_SCREEN = "\033[2J\033[;H"


def msgevalgen(pattern: str) -> Callable[[Any], Any] | None:
    """Return a function that returns a field of a message.

    Args:
        pattern: the path that follows the topic's name, for example ``/pose/position/x`` or ``/poses[0:2]``.

    Returns:
        The function, which prints an error and returns None for messages without the field. None if the path is empty,
        or malformed, which prints an error.
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
    """Return a function that yields the names of a message's fields, optionally without strings or arrays.

    Args:
        echo_nostr: whether to leave out strings.
        echo_noarr: whether to leave out arrays.
    """

    def field_filter(val: Any) -> Iterator[str]:
        for name, field_type in zip(val.__slots__, val._slot_types, strict=True):
            is_text = field_type == "string" or field_type.startswith(("string[", "std_msgs/String"))
            if not (echo_noarr and "[" in field_type) and not (echo_nostr and is_text):
                yield name

    return field_filter


class CallbackEcho:
    """Prints messages like ``rostopic echo``.

    Args:
        topic: the topic whose messages are printed; with `echo_all_topics`, also those of topics below it.
        msg_eval: function that returns the field of a message to print; None to print whole messages.
        plot: whether to print rows of values.
        filter_fn: function that returns whether to print a message; None to print all.
        echo_clear: whether to clear the screen before each message.
        echo_all_topics: whether to print messages of all topics.
        offset_time: whether to print times relative to the current time.
        count: number of messages to print; None for no limit.
        field_filter_fn: see `create_field_filter`.
        fixed_numeric_width: number of characters of each number.
        value_transform_fn: function that changes a message before it is printed.

    Attributes:
        done: whether `count` messages were printed.
    """

    def __init__(
        self,
        topic: str,
        msg_eval: Any,
        plot: bool = False,
        filter_fn: Any = None,
        echo_clear: bool = False,
        echo_all_topics: bool = False,
        offset_time: bool = False,
        count: int | None = None,
        field_filter_fn: Any = None,
        fixed_numeric_width: int | None = None,
        value_transform_fn: Any = None,
    ) -> None:
        self.topic = topic if not topic or topic[-1] == "/" or not echo_all_topics else topic + "/"
        self.msg_eval = msg_eval
        self.plot = plot
        self.filter_fn = filter_fn
        self.fixed_numeric_width = fixed_numeric_width
        self.prefix = _CLEAR_SCREEN if echo_clear else ""
        self.suffix = "" if plot else "\n---\n"
        self.echo_all_topics = echo_all_topics
        self.offset_time = offset_time
        self.done = False
        self.max_count = count
        self.count = 0
        self.field_filter = field_filter_fn
        self.value_transform = value_transform_fn
        self._table: Table | None = None
        self.last_topic: str | None = None
        self.last_msg_eval: Any = None

    def custom_strify_message(
        self,
        val: Any,
        indent: str = "",
        time_offset: Any = None,
        current_time: Any = None,
        field_filter: Any = None,
        type_information: str | None = None,
        fixed_numeric_width: int | None = None,
        value_transform: Any = None,
    ) -> str:
        """Return a message, or the value of a field, as text."""
        if value_transform is not None:
            val = value_transform(val, type_information)
        if isinstance(val, Message) or (type_information is not None and not isinstance(val, str)):
            text = format_message(
                val,
                width=fixed_numeric_width,
                time_offset=time_offset,
                field_filter=field_filter,
                type_name=type_information,
                indent=indent,
            ).lstrip("\n")
            return f"\n{text}" if indent else text
        return strify_message(
            val,
            indent,
            time_offset=time_offset,
            current_time=current_time,
            fixed_numeric_width=fixed_numeric_width,
        )

    def callback(self, data: Any, callback_args: Any, current_time: Any = None) -> None:
        """Print a message.

        Args:
            data: the message.
            callback_args: mapping with ``topic``, and ``type_information`` of a field or None.
            current_time: time to use instead of the current time, for messages from a bag.
        """
        topic = callback_args["topic"]
        if self.done or (self.filter_fn is not None and not self.filter_fn(data)):
            return
        msg_eval = self.msg_eval
        if topic != self.topic:
            if self.topic.startswith(f"{topic}/"):  # self.topic names a field of this topic, in a bag
                if topic != self.last_topic:
                    self.last_topic, self.last_msg_eval = topic, msgevalgen(self.topic[len(topic) :])
                msg_eval = self.last_msg_eval
            elif not self.echo_all_topics:
                return
        if self.max_count is not None and self.count >= self.max_count:
            self.done = True
            return
        value = data if msg_eval is None else msg_eval(data)
        if value is None:
            return
        self.count += 1
        offset = rospy.get_rostime() if self.offset_time else None
        sys.stdout.write(self.prefix)
        if self.plot:
            self._write_row(value, current_time, offset)
        else:
            text = self.custom_strify_message(
                value,
                time_offset=offset,
                current_time=current_time,
                field_filter=self.field_filter,
                type_information=callback_args.get("type_information"),
                fixed_numeric_width=self.fixed_numeric_width,
                value_transform=self.value_transform,
            )
            sys.stdout.write(text)
        sys.stdout.write(self.suffix)
        sys.stdout.flush()
        if self.max_count is not None and self.count >= self.max_count:
            self.done = True

    def _write_row(self, value: Any, current_time: Any, offset: Any) -> None:
        """Write a row of values with its time; before the first row, write a row of names."""
        if self._table is None:
            self._table = Table(field_filter=self.field_filter)
            self._table.emit_header(value, sys.stdout.write)
        if current_time is not None:
            stamp = current_time
        else:
            stamp = value.header.stamp if getattr(value, "_has_header", False) else rospy.get_rostime()
        nanoseconds = stamp.to_nsec() - (offset.to_nsec() if offset is not None else 0)
        self._table.emit_message(value, nanoseconds, sys.stdout.write, offset)
