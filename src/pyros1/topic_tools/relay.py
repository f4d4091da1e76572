"""relay: forwards a topic (https://wiki.ros.org/topic_tools/relay). drop and throttle are relays with a gate."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from pyros1.ground.errors import Error, NodeError
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.topic_tools.output import QUEUE_SIZE, Output

Gate = Callable[[AnyMsg], bool]
"""Decides whether a message passes."""


class Relay:
    """Forwards a topic.

    Args:
        node: the node that subscribes and publishes.
        source: the topic to subscribe to.
        output: the topic to publish.
        gate: decides whether a message passes; None to pass all messages.
        transports: the transports to request, see `Node.subscribe`.

    Raises:
        NodeError: both topics are the same.
    """

    def __init__(
        self,
        node: Node,
        source: str,
        output: Output,
        gate: Gate | None = None,
        transports: Sequence[str] = ("tcp",),
    ) -> None:
        if node.resolve(source) == output.topic:
            raise NodeError(f"{output.topic} would be forwarded to itself")
        self._source = source  # not resolved, since a resolved name would be remapped twice
        self._node = node
        self._output = output
        self._gate = gate
        self._transports = transports
        self._wake = threading.Event()  # set when a message arrives while the output has no subscriber, or at shutdown
        node.on_shutdown(self._wake.set)

    def run(self) -> None:
        """Forward messages until the node shuts down."""
        self._subscribe(self._receive)
        self._node.spin()

    def _subscribe(self, callback: Callable[[AnyMsg], None]) -> Subscriber[AnyMsg]:
        return self._node.subscribe(self._source, AnyMsg, callback, queue_size=QUEUE_SIZE, transports=self._transports)

    def run_lazy(self) -> None:
        """Forward messages until the node shuts down. Subscribe only while the output has subscribers."""
        while self._node.ok():
            with self._subscribe(self._receive_lazily):
                self._wake.wait()
            self._wake.clear()
            self._output.wait_for_subscriber()

    def run_stealth(self, monitored: str, period: float) -> None:
        """Forward messages until the node shuts down. Subscribe only while another node subscribes to `monitored`.

        Args:
            monitored: the monitored topic.
            period: the time between queries to the master in seconds.
        """
        monitored = self._node.resolve(monitored)
        subscriber = None
        is_needed = True
        while self._node.ok():
            if is_needed and subscriber is None:
                subscriber = self._subscribe(self._receive)
            elif not is_needed and subscriber is not None:
                subscriber.unregister()
                subscriber = None
            self._wake.wait(period)
            is_needed = self._has_subscribers(monitored, is_needed)

    def _has_subscribers(self, topic: str, default: bool) -> bool:
        try:
            _, subscribers, _ = self._node.master.get_system_state()
        except Error as error:
            if self._node.ok():
                self._node.log.error("cannot find the subscribers of %s: %s", topic, error, throttle=10.0)
            return default
        return any(set(nodes) - {self._node.name} for name, nodes in subscribers if name == topic)

    def _receive(self, message: AnyMsg) -> None:
        output = self._output
        if (message._connection_header is output.header or output.admit(message)) and (
            self._gate is None or self._gate(message)
        ):
            output.publish(message)

    def _receive_lazily(self, message: AnyMsg) -> None:
        if self._output.admit(message) and not self._output.has_subscribers:
            self._wake.set()
        else:
            self._receive(message)
