"""Topics that a client publishes on."""

from __future__ import annotations

from typing import Any

from pyros1.msgs import load_message
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.operations import Advertise, BridgeError
from pyros1.web.rosbridge.values import from_client

MOST_TOPICS = 500
_MOST_WAITING = 1000
_CONNECT = 0.5
"""Seconds that subscribers of a topic have to connect before its first message."""


class Publishers:
    """The publishers of one client, by the names that it gave.

    Args:
        robot: where they publish.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._publishers: dict[str, tuple[Any, type[Any]]] = {}
        self._silent: set[str] = set()

    def advertise(self, wish: Advertise) -> None:
        """Begin to publish on a topic; again with other wishes, these count.

        Raises:
            Error: no such type, the topic has another one, or too many topics.
        """
        node = self._robot.node
        topic = node.resolve(wish.topic)
        self._robot.check_visible(topic)
        cls = load_message(wish.type)
        known = self._robot.graph.topic_types().get(topic, "*")
        if known not in ("*", wish.type):
            raise BridgeError(f"{topic} has messages of the type {known}, not {wish.type}")
        self.unadvertise(wish.topic)
        if len(self._publishers) >= MOST_TOPICS:
            raise BridgeError(f"a client publishes on at most {MOST_TOPICS} topics")
        queue_size = min(wish.queue_size, _MOST_WAITING) or _MOST_WAITING
        try:
            publisher = node.advertise(topic, cls, queue_size=queue_size, latch=wish.latch)
        except TypeError as error:
            raise BridgeError(str(error)) from None
        self._publishers[wish.topic] = (publisher, cls)
        self._silent.add(wish.topic)

    def unadvertise(self, name: str) -> bool:
        """End it; return whether there was something to end."""
        publisher, _ = self._publishers.pop(name, (None, None))
        self._silent.discard(name)
        if publisher is None:
            return False
        publisher.unregister()
        return True

    def publish(self, name: str, value: Any) -> None:
        """Publish a message, which is a JSON object. A topic that is known need not be advertised.

        Raises:
            Error: nobody knows its type, or a value does not fit its field.
        """
        if name not in self._publishers:
            topic = self._robot.node.resolve(name)
            self._robot.check_visible(topic)
            kind = self._robot.graph.topic_types().get(topic, "*")
            if kind == "*":
                raise BridgeError(f"nobody has told the type of {topic}: advertise it")
            self.advertise(Advertise(name, kind, False, 0))
        publisher, cls = self._publishers[name]
        message = from_client(cls, value, self._robot.node.now())
        if name in self._silent:
            self._silent.discard(name)
            if self._robot.graph.state().subscribers.get(publisher.name):
                publisher.wait_for_subscribers(timeout=_CONNECT)
        publisher.publish(message)

    def close(self) -> None:
        """End all."""
        for name in list(self._publishers):
            self.unadvertise(name)
