"""Receives the log messages of all nodes, and converts them for output."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.log._loggers import LEVELS
from pyros1.cli.invocation import Invocation

if TYPE_CHECKING:
    from pyros1.msgs import Message

_POLL_PERIOD = 0.2
COLOURS = {1: "\x1b[94m", 2: "\x1b[92m", 4: "\x1b[93m", 8: "\x1b[91m", 16: "\x1b[95m"}
"""The escape sequences of the levels' colours, by the level's number."""
BOLD, DIM, RESET = "\x1b[1m", "\x1b[2m", "\x1b[0m"


def receive_messages(invocation: Invocation, topic: str | None = None) -> Iterator[Any]:
    """Yield the rosgraph_msgs/Log messages of all nodes as they arrive, until the command ends.

    Args:
        invocation: the command's invocation.
        topic: the full name of the topic to read; None for ``/rosout_agg`` if it is published, otherwise ``/rosout``.
    """
    if topic is None:
        # The aggregator provides all messages over one connection. Without it, a connection to each node is needed.
        topic = "/rosout_agg" if invocation.graph.state().publishers.get("/rosout_agg") else "/rosout"
    inbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
    with invocation.open_node() as node, node.subscribe(topic, "rosgraph_msgs/Log", inbox.put):
        while node.ok():
            try:
                yield inbox.get(timeout=_POLL_PERIOD)
            except queue.Empty:
                continue


def level_name(number: int) -> str:
    """Return the name of a level, or its number if the level does not exist."""
    return next((name for bit, name in enumerate(LEVELS) if 1 << bit == number), str(number))


def as_json(message: Any) -> dict[str, Any]:
    """Return a message as a JSON object: level, node, text, time in seconds and source location."""
    return {
        "level": level_name(message.level),
        "node": message.name,
        "text": message.msg,
        "stamp": message.header.stamp.secs + message.header.stamp.nsecs / 1e9,
        "function": message.function,
        "file": message.file,
        "line": message.line,
    }
