"""demux: forwards a topic to one of several outputs, selected by services (https://wiki.ros.org/topic_tools/demux)."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.topic_tools.output import QUEUE_SIZE, Output
from pyros1.topic_tools.selection import Selection

CONNECT_DELAY = 0.5
"""Time in seconds by which the first message on a new topic is delayed, so that subscribers can connect."""


class Demux:
    """Forwards a topic to the selected one of several output topics.

    Args:
        node: the node that subscribes, publishes and provides the services.
        source: the topic to subscribe to.
        targets: the output topics. The first one is selected.
    """

    def __init__(self, node: Node, source: str, targets: Sequence[str]) -> None:
        self._node = node
        self._shutdown = threading.Event()
        node.on_shutdown(self._shutdown.set)
        self._selection = Selection(node, "demux", targets)
        self._outputs: dict[str, Output] = {}
        for topic in self._selection.topics:
            self._add_output(topic)
        self._selection.on_added, self._selection.on_removed = self._add_output, self._remove_output
        node.subscribe(source, AnyMsg, self._receive, queue_size=QUEUE_SIZE)
        self._selection.serve()

    def run(self) -> None:
        """Forward messages until the node shuts down."""
        self._node.spin()

    def _add_output(self, topic: str) -> None:
        self._outputs = {**self._outputs, topic: Output(self._node, topic, latch=False)}

    def _remove_output(self, topic: str) -> None:
        output = self._outputs[topic]
        self._outputs = {name: other for name, other in self._outputs.items() if other is not output}
        output.close()

    def _receive(self, message: AnyMsg) -> None:
        outputs = self._outputs
        selected = outputs.get(self._selection.selected or "")
        is_new = selected is not None and not selected.is_advertised
        admitted = [message._connection_header is output.header or output.admit(message) for output in outputs.values()]
        if is_new and all(admitted):
            self._shutdown.wait(CONNECT_DELAY)
        if selected is not None and message._connection_header is selected.header:
            selected.publish(message)
