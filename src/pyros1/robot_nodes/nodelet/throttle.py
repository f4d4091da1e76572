"""Replaces nodelets made from nodelet_topic_tools' NodeletThrottle, for messages of any type.

They limit the rate of a topic: topic_in becomes topic_out (https://wiki.ros.org/nodelet_topic_tools). Packages define
such nodelets, with names like NodeletThrottleImage, for the types that they need.
"""

from __future__ import annotations

import threading
from typing import Any

from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.shared.lazy import LazyInputs
from pyros1.robot_nodes.shared.program import run_node
from pyros1.wire.handshake import TopicType

_QUEUE_SIZE = 10


class Throttle:
    """Forwards at most ``~update_rate`` messages per second. The rate can be changed with dynamic_reconfigure.

    topic_out is not advertised before the first message, since its type is unknown. After that, the node subscribes to
    topic_in only while topic_out has subscribers.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._rate = 0.0
        self._passed_at: float | None = None
        self._publisher: Any = None
        self._inputs: LazyInputs | None = None
        parameters = Parameters()
        parameters.add("update_rate", -1.0, "Maximum rate in Hz; 0 or less for no limit", minimum=-1.0)
        self._server = Server(node, parameters, self._configure)
        with self._lock:  # the first message may arrive before `_first` is set
            self._first = node.subscribe("topic_in", AnyMsg, self._begin, queue_size=_QUEUE_SIZE)

    def _configure(self, config: Any, level: int) -> Any:
        self._rate = config.update_rate
        return config

    def _begin(self, message: Any) -> None:
        """Advertise topic_out with the type of the first message."""
        with self._lock:
            if self._publisher is not None:
                return
            header = message._connection_header
            type = TopicType(header["type"], header["md5sum"], header.get("message_definition", ""))
            self._publisher = self._node.advertise("topic_out", AnyMsg, queue_size=_QUEUE_SIZE, raw_type=type)
        self._inputs = LazyInputs([self._publisher], self._open)
        self._first.unregister()

    def _open(self) -> list[Any]:
        return [self._node.subscribe("topic_in", AnyMsg, self._receive, queue_size=_QUEUE_SIZE).unregister]

    def _receive(self, message: Any) -> None:
        if self._is_due(self._node.now().to_sec()):
            self._publisher.publish(message)

    def _is_due(self, now: float) -> bool:
        """Return whether to forward a message now. If time has jumped back (as in a looping bag), this is True."""
        rate, last = self._rate, self._passed_at
        if rate > 0 and last is not None and last <= now < last + 1 / rate:
            return False
        self._passed_at = now
        return True


def main(argv: list[str]) -> int:
    """Run the node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "throttle", Throttle)
