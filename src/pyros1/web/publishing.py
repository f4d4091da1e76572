"""Publishes messages from pages, with one publisher per topic."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from time import monotonic
from typing import Any, NamedTuple

from pyros1.graph import Graph
from pyros1.msgs import Message, load_message
from pyros1.msgs.json_form import from_json
from pyros1.node import Node
from pyros1.web.server.wire import RequestError

_CONNECT_TIMEOUT = 2.0
"""Seconds to wait for subscribers to connect before the first message on a topic."""
IDLE_TIMEOUT, LATCHED_IDLE_TIMEOUT = 120.0, 3600.0
"""Seconds without messages after which a publisher is closed. Latched messages are kept longer, for later
subscribers."""
MAX_PUBLISHERS = 100
"""Maximum number of topics published at the same time; beyond that, the least recently used publisher is closed."""


class _PublisherKey(NamedTuple):
    topic: str
    type: str
    md5sum: str
    latch: bool


class PagePublishers:
    """The publishers that all pages share.

    Args:
        node: returns the server's node.
        find_class: returns the message class with a type's name, or raises MessageError.
        clock: returns the time in seconds.
    """

    def __init__(
        self,
        node: Callable[[], Node],
        find_class: Callable[[str], type[Message]] = load_message,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._node = node
        self._find_class = find_class
        self._clock = clock
        self._lock = threading.Lock()
        # The publishers and the times of their last use, the least recently used publisher first.
        self._publishers: dict[_PublisherKey, tuple[Any, float]] = {}

    def publish(self, topic: str, type_name: str, value: Any, latch: bool = False) -> int:
        """Publish a message.

        Args:
            topic: the topic's full name.
            type_name: the message type's name, for example ``std_msgs/Float64``.
            value: the message as JSON; missing fields get default values.
            latch: whether later subscribers also receive the message.

        Returns:
            The number of subscribers to which the message was sent.

        Raises:
            MessageError: the type does not exist, or a value does not fit its field.
            NodeError: the server publishes the topic with another type.
            RequestError: other nodes use the topic with another type.
        """
        node = self._node()
        cls = self._find_class(type_name)
        message = from_json(cls, value, node.now())
        publisher = self._get_publisher(node, topic, cls, latch)
        publisher.publish(message)
        connections: int = publisher.num_connections
        return connections

    def advertise(self, topic: str, type_name: str) -> None:
        """Create the publisher in advance, so that subscribers connect to it in time to receive the first message.

        Raises:
            MessageError: the type does not exist.
            NodeError: the server publishes the topic with another type.
        """
        self._get_publisher(self._node(), topic, self._find_class(type_name), False)

    def _get_publisher(self, node: Node, topic: str, cls: type[Message], latch: bool) -> Any:
        key = _PublisherKey(topic, cls._type, cls._md5sum, latch)
        with self._lock:
            existing, _ = self._publishers.pop(key, (None, 0.0))
            if existing is not None:
                self._publishers[key] = existing, self._clock()
                return existing
            obsolete = [other for other in self._publishers if other.topic == topic]
            while len(self._publishers) - len(obsolete) >= MAX_PUBLISHERS:
                obsolete.append(next(other for other in self._publishers if other not in obsolete))
            removed = [self._publishers.pop(other) for other in obsolete]
        _unregister_all(removed)
        node.master.ping()  # advertising would wait for an unreachable master
        _check_type(node, topic, cls._type)
        try:
            publisher = node.advertise(topic, cls, latch=latch)
        except TypeError as error:
            raise RequestError(str(error)) from None
        with self._lock:
            existing, _ = self._publishers.setdefault(key, (publisher, self._clock()))
        if existing is not publisher:
            publisher.unregister()  # another page has created one meanwhile
            return existing
        # Wait for all subscribers: otherwise only the fastest subscriber would receive the first message.
        publisher.wait_for_subscribers(len(Graph(node.master).state().subscribers.get(topic, ())), _CONNECT_TIMEOUT)
        return publisher

    def unadvertise(self, topic: str) -> None:
        """Close the publishers on a topic."""
        with self._lock:
            removed = [self._publishers.pop(key) for key in list(self._publishers) if key.topic == topic]
        _unregister_all(removed)

    def clean_up(self) -> None:
        """Close publishers that have not been used for a while."""
        now = self._clock()
        with self._lock:
            idle = {key: now - last_used_at for key, (_, last_used_at) in self._publishers.items()}
            expired = [
                key for key, seconds in idle.items() if seconds > (LATCHED_IDLE_TIMEOUT if key.latch else IDLE_TIMEOUT)
            ]
            removed = [self._publishers.pop(key) for key in expired]
        _unregister_all(removed)

    def close(self) -> None:
        """Close all publishers."""
        with self._lock:
            removed, self._publishers = list(self._publishers.values()), {}
        _unregister_all(removed)


def _check_type(node: Node, topic: str, type_name: str) -> None:
    """Reject a type if other nodes use another type for the topic: registering it would affect all of them."""
    graph = Graph(node.master)
    state = graph.state()
    other_nodes = {*state.publishers.get(topic, ()), *state.subscribers.get(topic, ())} - {node.name}
    existing = graph.topic_types().get(topic, "") if other_nodes else ""
    if existing not in ("", "*", type_name):
        raise RequestError(f"{topic} has the type {existing}, so no subscriber would accept a {type_name}")


def _unregister_all(publishers: Iterable[tuple[Any, float]]) -> None:
    for publisher, _ in publishers:
        publisher.unregister()
