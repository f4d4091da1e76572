"""Subscribes in ROS 1, converts the messages, and sends them to ROS 2."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD
from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.local_graph import LocalGraph
from pyros1.bridge.transport.sender import Sender
from pyros1.ground.errors import Error
from pyros1.ground.names import FullName
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.early_messages import EarlyMessages
from pyros1.ros2.bridge.plan import AnnouncedTopic
from pyros1.ros2.zenoh.names import DataKey

_QUEUE_SIZE = 1000
SubscribedTopics = Mapping[str, Sequence[tuple[DataKey, AnnouncedTopic]]]
"""ROS 1 topics that ROS 2 nodes subscribe to, each with the keys to send it with."""


class OutgoingMessages:
    """The subscribers of a bridge. All methods but `on_message` are for one thread.

    Args:
        node: the bridge's node; it must run callbacks inline.
        graph: receives the types that publishers send.
        sender: sends the packets.
        counts: counts the messages.
        warn: logs a warning, given its text and an error, for which ``%s`` stands in the text.

    Attributes:
        topics: what to send; set by the caller.
    """

    def __init__(
        self, node: Node, graph: LocalGraph, sender: Sender, counts: Counts, warn: Callable[[str, Exception], object]
    ) -> None:
        self.topics: SubscribedTopics = {}
        self._node = node
        self._graph = graph
        self._sender = sender
        self._counts = counts
        self._warn = warn
        self._publishers: Collection[str] = frozenset()  # those that exist in ROS 2
        self._early = EarlyMessages()
        self._subscribers: dict[str, Subscriber[AnyMsg]] = {}

    def on_message(self, local: str, message: AnyMsg) -> None:
        """Send a message. Called in the node's threads."""
        header = message._connection_header or {}
        publisher, md5sum = header.get("callerid", ""), header.get("md5sum", "")
        self._graph.check_type(publisher, local, md5sum)
        # A message from any bridge could cause a loop. A bridge publishes ROS 2's log over the connections of its own
        # log, which may lack the field; so its name is checked, too.
        if BRIDGE_FIELD in header or publisher in self._graph.bridges:
            return
        flow = self._counts.to_ros2(local)
        for key, announced in self.topics.get(local, ()):
            if md5sum != announced.local.md5sum:
                flow.drop("with a different md5sum")
                continue
            try:
                body = announced.pair.transcoder.to_cdr(message._buff)
            except Error as error:
                flow.drop("could not be converted")
                self._warn(f"cannot convert a message on {one_line(local)}: %s", error)
                continue
            packet = Send(announced.route(key, publisher), b"", body, announced.priority)
            if packet.key in self._publishers:
                self._sender.put(packet)
            else:
                self._early.put(packet)
            flow.count(len(body))

    def set_publishers(self, publishers: Collection[str]) -> None:
        """Record which publishers exist in ROS 2."""
        self._publishers = publishers

    def send_early(self) -> None:
        """Send the messages that came before their publisher existed in ROS 2."""
        for packet in self._early.pop(self._publishers):
            self._sender.put(packet)

    def adjust(self, problems: dict[str, str]) -> None:
        """Subscribe to exactly the topics in `topics`; add failures to `problems`."""
        for topic in self._subscribers.keys() - self.topics.keys():
            self._subscribers.pop(topic).unregister()
        for topic in self.topics.keys() - self._subscribers.keys():
            try:
                self._subscribers[topic] = self._node.subscribe(
                    FullName(topic), AnyMsg, partial(self.on_message, topic), queue_size=_QUEUE_SIZE
                )
            except Error as error:
                problems[topic] = one_line(error)

    def close(self) -> None:
        """Unsubscribe from all topics, until the next `adjust`."""
        for topic in [*self._subscribers]:  # a copy: the master thread may still change it
            if (subscriber := self._subscribers.pop(topic, None)) is not None:
                subscriber.unregister()
