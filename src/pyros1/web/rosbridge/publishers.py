"""Topics that a client publishes on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pyros1.msgs import load_message
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.operations import Advertise, BridgeError, Id, Publish
from pyros1.web.rosbridge.values import from_client

MOST_TOPICS = 500
_MOST_WAITING = 1000
_CONNECT = 0.5
"""Seconds that subscribers of a topic have to connect before its first message."""


@dataclass
class _Topic:
    publisher: Any
    cls: type[Any]
    wish: Advertise
    ids: set[Id] = field(default_factory=set)


class Publishers:
    """The publishers of one client, by the names that it gave.

    Args:
        robot: where they publish.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._topics: dict[str, _Topic] = {}
        self._silent: set[str] = set()

    def advertise(self, wish: Advertise, id: Id = None) -> None:
        """Begin to publish on a topic. Parts of a client may do so each with an id; the last wishes count.

        Raises:
            Error: no such type, the topic has another one, or too many topics.
        """
        node = self._robot.node
        topic = self._robot.full_name(wish.topic)
        self._robot.check_visible(topic)
        cls = load_message(wish.type)
        known = self._robot.type_of(topic, wish.type)
        if known not in ("*", wish.type):
            raise BridgeError(f"{topic} has messages of the type {known}, not {wish.type}")
        mine = self._topics.get(wish.topic)
        if mine is not None and (mine.wish, mine.cls) == (wish, cls):
            mine.ids.add(id)
            return
        if mine is None and len(self._topics) >= MOST_TOPICS:
            raise BridgeError(f"a client publishes on at most {MOST_TOPICS} topics")
        if mine is not None and mine.cls is not cls:
            self.unadvertise(wish.topic)
            mine = None
        queue_size = min(wish.queue_size, _MOST_WAITING) or _MOST_WAITING
        try:
            publisher = node.advertise(topic, cls, queue_size=queue_size, latch=wish.latch)
        except TypeError as error:
            raise BridgeError(str(error)) from None
        if mine is None:
            self._topics[wish.topic] = _Topic(publisher, cls, wish, {id})
            self._silent.add(wish.topic)
            return
        mine.ids.add(id)
        before, mine.publisher, mine.wish = mine.publisher, publisher, wish
        before.unregister()  # it was the same topic of the node: its subscribers stay connected

    def unadvertise(self, name: str, id: Id = None) -> bool:
        """End it, or, with an id, one of those who wanted it: the topic ends with the last.

        Returns:
            Whether the client publishes on the topic.
        """
        mine = self._topics.get(name)
        if mine is None:
            return False
        mine.ids = set() if id is None else mine.ids - {id}
        if not mine.ids:
            del self._topics[name]
            self._silent.discard(name)
            mine.publisher.unregister()
        return True

    def publish(self, wish: Publish) -> None:
        """Publish a message, which is a JSON object. A topic that is known need not be advertised.

        Raises:
            Error: nobody knows its type, or a value does not fit its field.
        """
        name = wish.topic
        if name not in self._topics:
            topic = self._robot.full_name(name)
            self._robot.check_visible(topic)
            kind = self._robot.type_of(topic)
            if kind == "*":
                raise BridgeError(f"the type of {topic} is not known: advertise it")
            self.advertise(Advertise(name, kind, wish.latch, 0))
        publisher = self._topics[name].publisher
        message = from_client(self._topics[name].cls, wish.message, self._robot.node.now())
        if name in self._silent:
            self._silent.discard(name)
            if self._robot.graph.state().subscribers.get(publisher.name):
                publisher.wait_for_subscribers(timeout=_CONNECT)
        publisher.publish(message)

    def close(self) -> None:
        """End all."""
        for name in list(self._topics):
            self.unadvertise(name)
