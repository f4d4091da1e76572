"""What a node offers around its log: the topic /rosout and the services ~get_loggers and ~set_logger_level (O18)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pyros1.errors import Error
from pyros1.msgs import load_message, load_service
from pyros1.node.log import NAMES, LogSink, Record, level_from_name

if TYPE_CHECKING:
    from pyros1.node.node import Node

QUEUE_SIZE = 100


def publish_log(node: Node, sink: LogSink) -> None:
    """Publish what a node logs on /rosout, latched."""
    log_class: Any = load_message("rosgraph_msgs/Log")
    publisher = node.advertise("/rosout", log_class, queue_size=QUEUE_SIZE, latch=True)

    def publish(record: Record) -> None:
        if publisher.name not in node._context.publications:
            return  # the node has ended; the message has been printed
        try:
            message = log_class()
            message.header.stamp = record.stamp
            message.level = record.level
            message.name = node.name
            message.msg = record.text
            message.file = record.file
            message.function = record.function
            message.line = record.line
            message.topics = [*node._context.publications, *node._topics.subscriptions]
            publisher.publish(message)
        except Error:
            pass  # the node is closing; the message has been printed

    sink.publish = publish


def offer_levels(node: Node, sink: LogSink) -> None:
    """Let others see and set a node's log levels."""
    get_loggers = load_service("roscpp/GetLoggers")
    logger_class = load_message("roscpp/Logger")

    def list_loggers(_request: Any) -> Any:
        response: Any = get_loggers._response_class()
        response.loggers = [logger_class(name=name, level=NAMES[level]) for name, level in sorted(sink.levels.items())]
        return response

    def set_level(request: Any) -> Any:
        sink.levels[request.logger] = level_from_name(request.level)
        return {}

    node._services.advertise(node.resolve("~get_loggers"), get_loggers, list_loggers, direct=True)
    set_logger_level = load_service("roscpp/SetLoggerLevel")
    node._services.advertise(node.resolve("~set_logger_level"), set_logger_level, set_level, direct=True)
