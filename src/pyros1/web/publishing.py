"""Topics that pages publish on."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from pyros1.msgs import Message, load_message
from pyros1.msgs.json_form import from_json
from pyros1.node import Node
from pyros1.web.wire import RequestError

_CONNECT = 0.5
"""Seconds that subscribers of a topic have to connect before its first message."""
MOST = 100
"""Most topics that are published at the same time; beyond that, the one that was used least recently ends."""


class Publishing:
    """The publishers.

    Args:
        node: returns the server's node.
        find: returns the class of a type; it raises MessageError.
    """

    def __init__(self, node: Callable[[], Node], find: Callable[[str], type[Message]] = load_message) -> None:
        self._node = node
        self._find = find
        self._lock = threading.Lock()
        self._publishers: dict[tuple[str, str, bool], Any] = {}

    def publish(self, topic: str, type_name: str, value: Any, latch: bool = False) -> int:
        """Publish a message.

        Args:
            topic: the topic's full name.
            type_name: the type, for example ``std_msgs/Float64``.
            value: the message as JSON; fields that are not named have their defaults.
            latch: whether subscribers that come later get it, too.

        Returns:
            The number of subscribers that it was sent to.

        Raises:
            MessageError: no such type, or a value does not fit its field.
            NodeError: the server publishes the topic with another type.
        """
        node = self._node()
        cls = self._find(type_name)
        message = from_json(cls, value, node.now())
        publisher = self._publisher(node, topic, cls, latch)
        publisher.publish(message)
        connections: int = publisher.num_connections
        return connections

    def advertise(self, topic: str, type_name: str) -> None:
        """Let subscribers connect before the first message, which they would miss else.

        Raises:
            MessageError: no such type.
            NodeError: the server publishes the topic with another type.
        """
        self._publisher(self._node(), topic, self._find(type_name), False)

    def _publisher(self, node: Node, topic: str, cls: type[Message], latch: bool) -> Any:
        key = (topic, cls._type, latch)
        with self._lock:
            known = self._publishers.pop(key, None)
            if known is not None:
                self._publishers[key] = known
                return known
            others = [each for each in self._publishers if each[0] == topic]
            while len(self._publishers) - len(others) >= MOST:
                others.append(next(each for each in self._publishers if each not in others))
            ended = [self._publishers.pop(each) for each in others]
        for publisher in ended:
            publisher.unregister()
        node.master.ping()  # to advertise would wait for a master that is away
        try:
            publisher = node.advertise(topic, cls, latch=latch)
        except TypeError as error:
            raise RequestError(str(error)) from None
        with self._lock:
            known = self._publishers.setdefault(key, publisher)
        if known is not publisher:
            publisher.unregister()  # another page was quicker
            return known
        publisher.wait_for_subscribers(timeout=_CONNECT)
        return publisher

    def close(self) -> None:
        """End all."""
        with self._lock:
            publishers, self._publishers = list(self._publishers.values()), {}
        for publisher in publishers:
            publisher.unregister()
