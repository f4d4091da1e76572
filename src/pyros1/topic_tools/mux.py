"""mux: forwards one of several topics to an output, selected by services (https://wiki.ros.org/topic_tools/mux)."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.topic_tools.output import QUEUE_SIZE, Output
from pyros1.topic_tools.selection import Selection


class Mux:
    """Forwards the selected one of several input topics to an output topic.

    Args:
        node: the node that subscribes, publishes and provides the services.
        target: the topic to publish.
        sources: the input topics.
        initial: the topic to select at the start, or ``__none``; empty for the first topic.
        lazy: whether to subscribe, once the type is known, only to the selected topic, and only while the output has
            subscribers.
        latch: whether to latch the output.
        connect_timeout: the maximum time in seconds to wait for a subscriber before the first message is published.
    """

    def __init__(
        self,
        node: Node,
        target: str,
        sources: Sequence[str],
        initial: str = "",
        lazy: bool = False,
        latch: bool = False,
        connect_timeout: float = 0.0,
    ) -> None:
        self._node = node
        self._lazy = lazy
        self._connect_timeout = connect_timeout
        self._output = Output(node, target, latch)
        self._subscribers: dict[str, Subscriber[AnyMsg]] = {}
        # Set when the type is known, when the output has no subscribers any more, or when the node shuts down.
        self._wake = threading.Event()
        node.on_shutdown(self._wake.set)
        self._selection = Selection(node, "mux", sources, initial)
        self._selection.on_added = self._selection.on_removed = self._update_subscriptions
        self._selection.on_changed = self._update_subscriptions
        self._update_subscriptions()
        self._selection.serve()
        self._deprecated_service = f"{target}_select"
        node.advertise_service(self._deprecated_service, "topic_tools/MuxSelect", self._select_deprecated)

    def run(self) -> None:
        """Forward messages until the node shuts down."""
        if not self._lazy:
            self._node.spin()
        while self._node.ok():
            self._wake.wait()
            self._wake.clear()
            self._update_subscriptions()
            self._output.wait_for_subscriber()
            self._update_subscriptions()

    def _select_deprecated(self, request: Any) -> Mapping[str, str]:
        self._node.log.warn("the service %s is deprecated: use mux/select", self._deprecated_service)
        return self._selection.select(request)

    def _update_subscriptions(self, *_: object) -> None:
        """Subscribe to the topics that are needed, and unsubscribe from all others."""
        with self._selection.lock:
            needed_topics = self._selection.topics
            if self._lazy and self._output.is_advertised:
                needed_topics = [
                    topic
                    for topic in needed_topics
                    if topic == self._selection.selected and self._output.has_subscribers
                ]
            for topic in [topic for topic in self._subscribers if topic not in needed_topics]:
                self._subscribers.pop(topic).unregister()
            for topic in needed_topics:
                if topic not in self._subscribers and self._node.ok():
                    receive = partial(self._receive, topic)
                    self._subscribers[topic] = self._node.subscribe(topic, AnyMsg, receive, queue_size=QUEUE_SIZE)

    def _receive(self, topic: str, message: AnyMsg) -> None:
        output = self._output
        if message._connection_header is not output.header:
            is_first = not output.is_advertised
            if not output.admit(message):
                return
            if is_first:
                output.wait_for_subscriber(self._connect_timeout)
                self._wake.set()
        if topic != self._selection.selected:
            return
        if self._lazy and not output.has_subscribers:
            self._wake.set()
        else:
            output.publish(message)
