"""An output topic, advertised when the first message reveals its type. It publishes messages without decoding them."""

from __future__ import annotations

import threading

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.log.levels import ERROR
from pyros1.node.publishing.publisher import Publisher
from pyros1.wire.handshake import TopicType

QUEUE_SIZE = 100
"""Queue size in messages, for slow subscribers and for input from fast publishers."""
LARGE_BYTES = 1 << 16
SMALL_QUEUE_SIZE = 10
"""Queue size in messages for slow subscribers if the first message has more than `LARGE_BYTES` bytes."""


class Output:
    """The topic to which messages are forwarded.

    Args:
        node: the node that publishes.
        topic: the topic's name.
        latch: whether to latch the topic; None to latch it if the publisher of the first message does.

    Attributes:
        header: the connection header of the last publisher whose message had the topic's type.
    """

    def __init__(self, node: Node, topic: str, latch: bool | None = None) -> None:
        self.topic = node.resolve(topic)
        self._unresolved_name = topic  # advertised under this name, since a resolved name would be remapped twice
        self.header: dict[str, str] | None = None
        self._node = node
        self._latch = latch
        self._type: TopicType | None = None
        self._publisher: Publisher[AnyMsg] | None = None
        self._lock = threading.Lock()

    @property
    def is_advertised(self) -> bool:
        """Whether the topic is advertised, which happens when the first message arrives."""
        return self._publisher is not None

    @property
    def has_subscribers(self) -> bool:
        """Whether the topic has subscribers."""
        return self._publisher is not None and self._publisher.num_connections > 0

    def admit(self, message: AnyMsg) -> bool:
        """Return whether a message has the topic's type. The first message sets the type and advertises the topic.

        Call this for each message whose ``_connection_header`` is not the same object as `header`.
        """
        header = message._connection_header or {}
        message_type = TopicType(
            header.get("type", "*"), header.get("md5sum", "*"), header.get("message_definition", "")
        )
        with self._lock:
            if self._type is None:
                self._advertise(
                    message_type,
                    header.get("latching") == "1",
                    SMALL_QUEUE_SIZE if len(message._buff) > LARGE_BYTES else QUEUE_SIZE,
                )
            topic_type = self._type or message_type
            if topic_type.md5sum != message_type.md5sum:
                log_format, publisher_name = (
                    "%s has the type %s, not %s: messages from %s are dropped",
                    header.get("callerid", "?"),
                )
                self._node.log.peer_event(
                    ERROR, log_format, self.topic, topic_type.name, message_type.name, publisher_name
                )
                return False
            self.header = header
            return True

    def _advertise(self, message_type: TopicType, is_latched: bool, queue_size: int) -> None:
        latch = is_latched if self._latch is None else self._latch
        self._publisher = self._node.advertise(
            self._unresolved_name, AnyMsg, queue_size=queue_size, latch=latch, raw_type=message_type
        )
        self._type = message_type
        self._node.log.info(
            "advertised %s, %s%s", self.topic, one_line(message_type.name), ", latched" if latch else ""
        )

    def publish(self, message: AnyMsg) -> None:
        """Publish a message that `admit` has accepted."""
        publisher = self._publisher
        if publisher is not None:
            publisher.publish(message)

    def wait_for_subscriber(self, timeout: float | None = None) -> None:
        """Wait until there is a subscriber or the node shuts down.

        Args:
            timeout: the maximum time to wait in seconds.
        """
        if self._publisher is not None:
            self._publisher.wait_for_subscribers(1, timeout)

    def close(self) -> None:
        """Unregister the topic."""
        with self._lock:
            publisher, self._publisher, self._type, self.header = self._publisher, None, None, None
        if publisher is not None:
            publisher.unregister()


def base_name(topic: str) -> str:
    """Return the last part of a topic's name, for the name of the node that forwards it.

    Raises:
        Error: the name has no last part.
    """
    base = topic.rstrip("/").rpartition("/")[2]
    if not base:
        raise Error(f"{topic!r} is not a legal topic name")
    return base
