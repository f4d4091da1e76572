"""Makes a node's log available to other nodes: the topic /rosout and the services ~get_loggers and ~set_logger_level
(O18).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, MasterError, MasterMethodError
from pyros1.msgs import load_message, load_service
from pyros1.node.log.levels import LEVEL_NAMES, level_from_name
from pyros1.node.log.logger import Log
from pyros1.node.log.sink import LogSink, Record
from pyros1.node.topic_type import topic_type

if TYPE_CHECKING:
    from pyros1.node.services.methods import Services
    from pyros1.node.topics import Topics

QUEUE_SIZE = 100


def offer_log(
    log: Log,
    sink: LogSink,
    node_name: str,
    topics: Topics,
    services: Services,
    resolve: Callable[[str], str],
    rosout: bool,
    log_services: bool,
    strict: bool,
) -> None:
    """Publish a node's log, and offer services that return and set its levels, if the master accepts them.

    Args:
        log, sink: the node's log and its sink.
        node_name: the node's full name.
        topics, services: the node's topics and services.
        resolve: resolves a name to a full name.
        rosout: whether to publish the log.
        log_services: whether to offer the services.
        strict: whether to raise the error if the master refuses the node; otherwise the node logs a warning and runs
            without the topic or services, like a stock rospy node whose name contains a space.

    Raises:
        MasterError: the master refuses the node.
    """
    steps: list[Callable[[], None]] = []
    if rosout:
        steps.append(lambda: _publish_log(sink, node_name, topics, resolve))
    if log_services:
        steps.append(lambda: _offer_levels(sink, services, resolve))
    for step in steps:
        try:
            step()
        except MasterError as error:
            if strict and not isinstance(error, MasterMethodError):
                raise
            log.warn("/rosout or the services for log levels are not available: %s", error)


def _publish_log(sink: LogSink, node_name: str, topics: Topics, resolve: Callable[[str], str]) -> None:
    """Make a node's sink publish each log message on /rosout, latched."""
    log_class: Any = load_message("rosgraph_msgs/Log")
    publisher = topics.advertise(resolve("/rosout"), log_class, topic_type(log_class), QUEUE_SIZE, True, {})

    def publish(record: Record) -> None:
        if publisher.name not in topics.publications:
            return  # the node has shut down; the message has been printed
        try:
            message = log_class()
            message.header.stamp = record.stamp
            message.level = record.level
            message.name = node_name
            message.msg = record.text
            message.file = record.file
            message.function = record.function
            message.line = record.line
            message.topics = [*{**topics.publications, **topics.subscriptions}]
            publisher.publish(message)
        except Error:
            pass  # the node is shutting down; the message has been printed

    sink.publish = publish


def _offer_levels(sink: LogSink, services: Services, resolve: Callable[[str], str]) -> None:
    """Offer services that return and set a node's log levels."""
    get_loggers = load_service("roscpp/GetLoggers")
    logger_class = load_message("roscpp/Logger")

    def list_loggers(_request: Any) -> Any:
        response: Any = get_loggers._response_class()
        response.loggers = [
            logger_class(name=name, level=LEVEL_NAMES[level]) for name, level in sorted(sink.levels.items())
        ]
        return response

    def set_level(request: Any) -> Any:
        sink.levels[request.logger] = level_from_name(request.level)
        return {}

    services.advertise(resolve("~get_loggers"), get_loggers, list_loggers, direct=True)
    set_logger_level = load_service("roscpp/SetLoggerLevel")
    services.advertise(resolve("~set_logger_level"), set_logger_level, set_level, direct=True)
