"""Printing of messages as they come."""

from __future__ import annotations

import sys
from typing import Any

import rospy
from genpy import Message
from genpy.message import strify_message

from pyros1.msgs.text import format_message
from rostopic._fields import Shown, _str_plot, _str_plot_fields, msgevalgen

_CLEAR = "\033[2J\033[;H"


class CallbackEcho:
    """Prints messages, as ``rostopic echo``.

    Args:
        topic: only messages of this topic, or with `echo_all_topics` of those below.
        msg_eval: function that returns a field; None: whole messages.
        plot: whether to print rows of values.
        filter_fn: function that tells whether a message is printed.
        echo_clear: whether to clear the screen before each message.
        echo_all_topics: whether to print messages of all topics.
        offset_time: whether to print times as differences to the present.
        count: number of messages after which it is done.
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
        self.prefix = _CLEAR if echo_clear else ""
        self.suffix = "" if plot else "\n---"
        self.echo_all_topics = echo_all_topics
        self.offset_time = offset_time
        self.done = False
        self.max_count = count
        self.count = 0
        self.str_fn = _str_plot if plot else self.custom_strify_message
        self.field_filter = field_filter_fn
        self.value_transform = value_transform_fn
        self.first = True
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
        options: dict[str, bool] = {}
        if isinstance(val, Shown):
            options = {"no_string": val.no_string, "no_array": val.no_array}
            val = val.message
        if isinstance(val, Message) or (type_information is not None and not isinstance(val, str)):
            text = format_message(
                val,
                width=fixed_numeric_width,
                time_offset=time_offset,
                field_filter=field_filter,
                type_name=type_information,
                indent=indent,
                **options,
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
            current_time: time in place of the present, for messages of a bag.
        """
        topic = callback_args["topic"]
        if self.done or (self.filter_fn is not None and not self.filter_fn(data)):
            return
        msg_eval = self.msg_eval
        if topic != self.topic:
            if self.topic.startswith(f"{topic}/"):  # a field of a bag's topic
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
        if self.plot and self.first:
            sys.stdout.write("%" + _str_plot_fields(value, "field", self.field_filter) + "\n")
            self.first = False
        offset = rospy.get_rostime() if self.offset_time else None
        text = self.str_fn(
            value,
            time_offset=offset,
            current_time=current_time,
            field_filter=self.field_filter,
            type_information=callback_args.get("type_information"),
            fixed_numeric_width=self.fixed_numeric_width,
            value_transform=self.value_transform,
        )
        sys.stdout.write(f"{self.prefix}{text}{self.suffix}\n")
        sys.stdout.flush()
        if self.max_count is not None and self.count >= self.max_count:
            self.done = True
