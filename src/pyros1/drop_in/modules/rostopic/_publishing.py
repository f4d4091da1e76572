"""Publishes messages from values, files or the standard input."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any, TextIO

import genpy
import roslib.message
import rospy
import yaml
from genpy.message import fill_message_args, get_printable_message_args
from rosgraph.names import script_resolve_name

NAME = "rostopic"
_ONCE_DURATION = 3.0
"""Seconds for which a message published once stays available to subscribers."""


def _topic_error(text: str) -> Exception:
    from rostopic import ROSTopicException

    return ROSTopicException(text)


def create_publisher(topic_name: str, topic_type: str, latch: bool, disable_rostime: bool = True) -> tuple[Any, Any]:
    """Start a node, and return a publisher and its message class.

    Raises:
        ROSTopicException: there is no definition of the type, or the type's name has no package.
    """
    name = script_resolve_name(NAME, topic_name)
    try:
        cls = roslib.message.get_message_class(topic_type)
    except ValueError:
        raise _topic_error(f"invalid topic type: {topic_type}") from None
    if cls is None:
        package = topic_type.partition("/")[0]
        raise _topic_error(
            f"invalid message type: {topic_type}.\nIf this is a valid message type, perhaps you need to type "
            f"'rosmake {package}'"
        )
    rospy.init_node(NAME, anonymous=True, disable_rosout=True, disable_rostime=disable_rostime)
    return rospy.Publisher(name, cls, latch=latch, queue_size=100), cls


def wait_for_subscriber(pub: Any, timeout: float) -> None:
    """Wait until a publisher has a subscriber, but not longer than ``timeout`` seconds."""
    deadline = time.monotonic() + timeout
    while pub.get_num_connections() == 0 and time.monotonic() < deadline and not rospy.is_shutdown():
        time.sleep(0.01)


def publish_message(
    pub: Any,
    msg_class: Any,
    pub_args: Any,
    rate: float | None = None,
    once: bool = False,
    verbose: bool = False,
    substitute_keywords: bool = False,
) -> None:
    """Publish a message with given values.

    Args:
        pub: the publisher.
        msg_class: class of the messages.
        pub_args: a list of values, or a list that contains one mapping, name -> value.
        rate: rate in Hz; None to publish one message, and keep it available until the node shuts down.
        once: whether to return after one message: at once, or after 3 seconds if there is no rate.
        verbose: whether to print the message.
        substitute_keywords: whether to replace the words ``now`` and ``auto`` again for each message.

    Raises:
        ROSTopicException: the values do not fit the type.
    """

    def message() -> Any:
        new_message = msg_class()
        try:
            fill_message_args(new_message, pub_args, keys={"now": rospy.get_rostime(), "auto": _now_header()})
        except genpy.MessageException as error:
            raise _topic_error(f"{error}\n\nArgs are: [{get_printable_message_args(new_message)}]") from None
        return new_message

    first = message()
    if rate is None:
        description = f"[{first}]" if verbose else "message"
        print(
            f"publishing and latching {description}"
            + (f" for {_ONCE_DURATION} seconds" if once else ". Press ctrl-C to terminate")
        )
        sys.stdout.flush()
        pub.publish(first)
        if once:
            deadline = time.monotonic() + _ONCE_DURATION
            while time.monotonic() < deadline and not rospy.is_shutdown():
                time.sleep(0.05)
        else:
            rospy.spin()
        return
    loop_rate = rospy.Rate(rate)
    while not rospy.is_shutdown():
        pub.publish(message() if substitute_keywords else first)
        if verbose:
            print(f"publishing {first}")
        if once:
            break
        loop_rate.sleep()


def _now_header() -> Any:
    from pyros1.msgs.std_msgs.msg import Header

    return Header(stamp=rospy.get_rostime())


def _parse_documents(text: str) -> Iterator[Any]:
    try:
        for document in yaml.safe_load_all(text):
            if document is not None:
                yield document
    except yaml.YAMLError as error:
        raise _topic_error(f"Invalid YAML: {error}") from None


def _read_documents(file: TextIO) -> Iterator[Any]:
    """Yield the values of the YAML documents in a file as they are read; ``---`` ends a document."""
    lines: list[str] = []
    for line in file:
        if line.startswith("---"):
            yield from _parse_documents("".join(lines))
            lines = []
        else:
            lines.append(line)
    yield from _parse_documents("".join(lines))


def stdin_publish(
    pub: Any, msg_class: Any, rate: float | None, once: bool, filename: str | None, verbose: bool
) -> None:
    """Publish the documents in a YAML file or on the standard input, at a rate or as they are read.

    Raises:
        ROSTopicException: the file does not exist or is invalid, or the values do not fit the type.
    """
    if filename and not os.path.isfile(filename):
        raise _topic_error(f"file does not exist: {filename}")
    with open(filename, encoding="utf-8") if filename else nullcontext(sys.stdin) as file:
        _publish_documents(pub, msg_class, rospy.Rate(rate) if rate else None, once, verbose, _read_documents(file))
    time.sleep(0.2)


def _publish_documents(
    pub: Any, msg_class: Any, loop_rate: Any, once: bool, verbose: bool, documents: Iterator[Any]
) -> None:
    for number, values in enumerate(documents):
        if rospy.is_shutdown():
            return
        if number and loop_rate is not None:
            loop_rate.sleep()
        message = msg_class()
        try:
            arguments = values if isinstance(values, list) else [values]
            fill_message_args(message, arguments, keys={"now": rospy.get_rostime(), "auto": _now_header()})
        except genpy.MessageException as error:
            raise _topic_error(f"{error}\n\nArgs are: [{get_printable_message_args(message)}]") from None
        if not number:
            wait_for_subscriber(pub, _ONCE_DURATION)
        if verbose:
            print(message)
        pub.publish(message)
        if once:
            break
