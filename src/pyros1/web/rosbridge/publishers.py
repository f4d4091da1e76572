"""Publishes messages from a client."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pyros1.msgs import load_message
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.operations import Advertise, BridgeError, Id, Publish
from pyros1.web.rosbridge.values import from_client

MAX_TOPICS = 500
_MAX_QUEUE_SIZE = 1000
_CONNECT_TIMEOUT = 0.5
"""Seconds to wait for subscribers to connect before the first message on a topic."""


@dataclass
class _Topic:
    publisher: Any
    cls: type[Any]
    request: Advertise
    ids: set[Id] = field(default_factory=set)


class Publishers:
    """The publishers of one client. Topics are identified by the names that the client has sent.

    Args:
        robot: the robot on whose topics the client publishes.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._topics: dict[str, _Topic] = {}
        self._never_published: set[str] = set()

    def advertise(self, request: Advertise, id: Id = None) -> None:
        """Start publishing on a topic.

        A client may advertise the same topic several times, with different ids. The options of the last advertisement
        apply.

        Raises:
            Error: the type does not exist, the topic has another type, or there are too many topics.
        """
        node = self._robot.node
        topic = self._robot.full_name(request.topic)
        self._robot.check_visible(topic)
        cls = load_message(request.type)
        current_type = self._robot.type_of(topic, request.type)
        if current_type not in ("*", request.type):
            raise BridgeError(f"{topic} has messages of the type {current_type}, not {request.type}")
        entry = self._topics.get(request.topic)
        if entry is not None and (entry.request, entry.cls) == (request, cls):
            entry.ids.add(id)
            return
        if entry is None and len(self._topics) >= MAX_TOPICS:
            raise BridgeError(f"a client can publish on at most {MAX_TOPICS} topics")
        if entry is not None and entry.cls is not cls:
            self.unadvertise(request.topic)
            entry = None
        queue_size = min(request.queue_size, _MAX_QUEUE_SIZE) or _MAX_QUEUE_SIZE
        try:
            publisher = node.advertise(topic, cls, queue_size=queue_size, latch=request.latch)
        except TypeError as error:
            raise BridgeError(str(error)) from None
        if entry is None:
            self._topics[request.topic] = _Topic(publisher, cls, request, {id})
            self._never_published.add(request.topic)
            return
        entry.ids.add(id)
        previous, entry.publisher, entry.request = entry.publisher, publisher, request
        previous.unregister()  # the new publisher keeps the topic's subscribers connected

    def unadvertise(self, name: str, id: Id = None) -> bool:
        """Stop publishing on a topic.

        With an id, only the advertisement made with that id is withdrawn. The publisher is closed when none of the
        client's advertisements of the topic is left.

        Returns:
            Whether the client was publishing on the topic.
        """
        entry = self._topics.get(name)
        if entry is None:
            return False
        entry.ids = set() if id is None else entry.ids - {id}
        if not entry.ids:
            del self._topics[name]
            self._never_published.discard(name)
            entry.publisher.unregister()
        return True

    def publish(self, request: Publish) -> None:
        """Publish a message, given as a JSON object. The client need not advertise a topic whose type is known.

        Raises:
            Error: the topic's type is unknown, or a value does not fit its field.
        """
        name = request.topic
        if name not in self._topics:
            topic = self._robot.full_name(name)
            self._robot.check_visible(topic)
            type_name = self._robot.type_of(topic)
            if type_name == "*":
                raise BridgeError(f"the type of {topic} is unknown: advertise it")
            self.advertise(Advertise(name, type_name, request.latch, 0))
        publisher = self._topics[name].publisher
        message = from_client(self._topics[name].cls, request.message, self._robot.node.now())
        if name in self._never_published:
            self._never_published.discard(name)
            if self._robot.graph.state().subscribers.get(publisher.name):
                publisher.wait_for_subscribers(timeout=_CONNECT_TIMEOUT)
        publisher.publish(message)

    def close(self) -> None:
        """Close all publishers."""
        for name in list(self._topics):
            self.unadvertise(name)
