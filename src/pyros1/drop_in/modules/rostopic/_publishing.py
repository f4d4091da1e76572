"""Publishing messages from values, files and the standard input."""

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
_ONCE = 3.0
"""Seconds for which a message that is published once stays available to subscribers."""


def _refused(text: str) -> Exception:
    from rostopic import ROSTopicException

    return ROSTopicException(text)


def create_publisher(topic_name: str, topic_type: str, latch: bool, disable_rostime: bool = True) -> tuple[Any, Any]:
    """Start a node, and return a publisher with the class of its messages.

    Raises:
        ROSTopicException: there is no definition of the type, or no package is named.
    """
    name = script_resolve_name(NAME, topic_name)
    try:
        cls = roslib.message.get_message_class(topic_type)
    except ValueError:
        raise _refused(f"invalid topic type: {topic_type}") from None
    if cls is None:
        package = topic_type.partition("/")[0]
        raise _refused(
            f"invalid message type: {topic_type}.\nIf this is a valid message type, perhaps you need to type "
            f"'rosmake {package}'"
        )
    rospy.init_node(NAME, anonymous=True, disable_rosout=True, disable_rostime=disable_rostime)
    return rospy.Publisher(name, cls, latch=latch, queue_size=100), cls


def wait_for_subscriber(pub: Any, timeout: float) -> None:
    """Wait until a publisher has a subscriber, or some seconds have passed."""
    until = time.monotonic() + timeout
    while pub.get_num_connections() == 0 and time.monotonic() < until and not rospy.is_shutdown():
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
        pub_args: list of values, or of one mapping.
        rate: how often in Hz; None: once, and wait until the node ends.
        once: whether to return a while after the message was sent.
        verbose: whether to print the message.
        substitute_keywords: whether the words ``now`` and ``auto`` stand for the time, anew with each message.

    Raises:
        ROSTopicException: the values do not fit.
    """

    def message() -> Any:
        made = msg_class()
        try:
            fill_message_args(made, pub_args, keys={"now": rospy.get_rostime(), "auto": _now_header()})
        except genpy.MessageException as error:
            raise _refused(f"{error}\n\nArgs are: [{get_printable_message_args(made)}]") from None
        return made

    first = message()
    if rate is None:
        what = f"[{first}]" if verbose else "message"
        print(f"publishing and latching {what}" + (f" for {_ONCE} seconds" if once else ". Press ctrl-C to terminate"))
        sys.stdout.flush()
        pub.publish(first)
        if once:
            until = time.monotonic() + _ONCE
            while time.monotonic() < until and not rospy.is_shutdown():
                time.sleep(0.05)
        else:
            rospy.spin()
        return
    pace = rospy.Rate(rate)
    while not rospy.is_shutdown():
        pub.publish(message() if substitute_keywords else first)
        if verbose:
            print(f"publishing {first}")
        if once:
            break
        pace.sleep()


def _now_header() -> Any:
    from pyros1.msgs.std_msgs.msg import Header

    return Header(stamp=rospy.get_rostime())


def _values(text: str) -> Iterator[Any]:
    try:
        for document in yaml.safe_load_all(text):
            if document is not None:
                yield document
    except yaml.YAMLError as error:
        raise _refused(f"Invalid YAML: {error}") from None


def _documents(file: TextIO) -> Iterator[Any]:
    """Yield the values of the documents of a file as they come; ``---`` ends one."""
    lines: list[str] = []
    for line in file:
        if line.startswith("---"):
            yield from _values("".join(lines))
            lines = []
        else:
            lines.append(line)
    yield from _values("".join(lines))


def stdin_publish(
    pub: Any, msg_class: Any, rate: float | None, once: bool, filename: str | None, verbose: bool
) -> None:
    """Publish the documents of a YAML file, or of the standard input: at a rate, or as they come.

    Raises:
        ROSTopicException: there is no such file, it is not valid, or the values do not fit.
    """
    if filename and not os.path.isfile(filename):
        raise _refused(f"file does not exist: {filename}")
    with open(filename, encoding="utf-8") if filename else nullcontext(sys.stdin) as file:
        _publish_documents(pub, msg_class, rospy.Rate(rate) if rate else None, once, verbose, _documents(file))
    time.sleep(0.2)


def _publish_documents(
    pub: Any, msg_class: Any, pace: Any, once: bool, verbose: bool, documents: Iterator[Any]
) -> None:
    for number, values in enumerate(documents):
        if rospy.is_shutdown():
            return
        if number and pace is not None:
            pace.sleep()
        made = msg_class()
        try:
            arguments = values if isinstance(values, list) else [values]
            fill_message_args(made, arguments, keys={"now": rospy.get_rostime(), "auto": _now_header()})
        except genpy.MessageException as error:
            raise _refused(f"{error}\n\nArgs are: [{get_printable_message_args(made)}]") from None
        if not number:
            wait_for_subscriber(pub, _ONCE)
        if verbose:
            print(made)
        pub.publish(made)
        if once:
            break
