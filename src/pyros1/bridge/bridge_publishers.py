"""The topics that a bridge publishes on its site's master, with the types and definitions of their original publishers.

A node publishes each topic once, but keeps the last latched message of each of its publisher objects. So there is one
publisher object for each original publisher with a latched message, and one more that keeps the topic advertised.
"""

from __future__ import annotations

import threading
from collections.abc import Collection, Mapping

from pyros1.bridge.exchange.actions import Advertise, Forget, Publish, Source
from pyros1.ground.names import FullName
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.log.levels import WARN
from pyros1.node.publishing.publisher import Publisher
from pyros1.wire.handshake import TopicType

BRIDGE_FIELD = "pyros1_bridge"
"""Field in the connection headers of bridges' publishers, with the site's name."""
ORIGIN_FIELD = "origin"
"""Field in the connection headers of bridges' publishers, with the original publishers at the time of the connection,
such as ``red:/driver``. The field ``callerid`` has the name of the bridge's node: only that node is registered with
this master, and it sends all original publishers' messages over one connection.
"""
_QUEUE_SIZE = 100
LATCHED_BYTES = 256 << 20
"""Maximum total size in bytes of another site's latched messages; at least one is kept."""
MESSAGE_COST = 1_000
"""Approximate bytes that a latched message takes besides its body, since it has a publisher of its own."""


class _Topic:
    def __init__(self, action: Advertise, publisher: Publisher[AnyMsg]) -> None:
        self.action = action
        self.publisher = publisher
        self.latched: dict[Source, Publisher[AnyMsg]] = {}
        self.origins = action.origins
        self.keeps_messages = action.latched  # once latched, a node's topic stays latched


class BridgePublishers:
    """The publishers of a bridge on its site's master.

    Args:
        node: the bridge's node.
        site: the site's name.

    Attributes:
        forgotten: number of latched messages discarded because their site exceeded the limit.
    """

    def __init__(self, node: Node, site: str) -> None:
        self.forgotten = 0
        self._node = node
        self._headers: Mapping[str, str] = {BRIDGE_FIELD: site}
        self._topics: dict[str, _Topic] = {}
        # site -> topic and source -> size of the latched message, the newest last
        self._sizes: dict[str, dict[tuple[str, Source], int]] = {}
        self._totals: dict[str, int] = {}
        self._lock = threading.Lock()  # one thread advertises and withdraws topics, others publish messages

    def advertise(self, action: Advertise) -> None:
        """Publish a topic, or change whether a published one is latched, keeping its subscribers. This waits for the
        master.

        Raises:
            Error: the master refuses it, or does not respond.
        """
        publisher = self._make_publisher(action, action.origins)
        with self._lock:
            topic = self._topics.get(action.local)
            if topic is None:
                self._topics[action.local] = _Topic(action, publisher)
                return
            topic.publisher, publisher = publisher, topic.publisher
            topic.action = action
            topic.keeps_messages = topic.keeps_messages or action.latched
        publisher.unregister()

    def set_origins(self, local: str, origins: tuple[str, ...]) -> None:
        """Name other original publishers in the headers of new connections."""
        with self._lock:
            topic = self._topics.get(local)
            if topic is not None:
                # The topic is published already, so this does not wait for the master.
                old, topic.origins = topic.publisher, origins
                topic.publisher = self._make_publisher(topic.action, origins)
                old.unregister()

    def _make_publisher(self, action: Advertise, origins: tuple[str, ...]) -> Publisher[AnyMsg]:
        return self._node.advertise(
            FullName(action.local),
            AnyMsg,
            queue_size=_QUEUE_SIZE,
            latch=action.latched,
            headers={**self._headers, ORIGIN_FIELD: " ".join(origins)},
            raw_type=TopicType(action.type, action.md5sum, action.definition),
        )

    def withdraw(self, local: str) -> None:
        """Stop publishing a topic. This waits for the master."""
        with self._lock:
            topic = self._topics.pop(local, None)
            for source in topic.latched if topic is not None else ():
                self._note_size(local, source, None)
        if topic is not None:
            for publisher in (*topic.latched.values(), topic.publisher):
                publisher.unregister()

    def publish(self, action: Publish) -> bool:
        """Publish a message, and return whether the topic is published."""
        with self._lock:
            topic = self._topics.get(action.local)
            if topic is None:
                return False
            publisher = topic.publisher
            if action.latched:
                if action.source not in topic.latched:
                    # The topic is published already, so this does not wait for the master.
                    topic.latched[action.source] = self._make_publisher(topic.action, topic.origins)
                publisher = topic.latched[action.source]
                self._note_size(action.local, action.source, MESSAGE_COST + len(action.body))
                self._forget_oldest(action.source[0])
            elif topic.keeps_messages:
                # This message must not stay latched: unregistering its publisher discards it.
                with self._make_publisher(topic.action, topic.origins) as passing:
                    passing.publish(AnyMsg(action.body))
                return True
            # With the lock held, since another thread may replace the publisher; publishing never waits.
            publisher.publish(AnyMsg(action.body))
        return True

    def forget(self, action: Forget) -> None:
        """Discard the last message of a source."""
        with self._lock:
            topic = self._topics.get(action.local)
            publisher = topic.latched.pop(action.source, None) if topic is not None else None
            self._note_size(action.local, action.source, None)
        if publisher is not None:
            publisher.unregister()

    def _note_size(self, local: str, source: Source, size: int | None) -> None:
        """Record the size of a latched message; None if it is gone. Called with the lock held."""
        sizes = self._sizes.setdefault(source[0], {})
        self._totals[source[0]] = self._totals.get(source[0], 0) + (size or 0) - sizes.pop((local, source), 0)
        if size is not None:
            sizes[local, source] = size
        if not sizes:
            del self._sizes[source[0]], self._totals[source[0]]

    def _forget_oldest(self, site: str) -> None:
        """Forget a site's oldest latched messages if their total size exceeds the limit. Called with the lock held."""
        while len(self._sizes[site]) > 1 and self._totals[site] > LATCHED_BYTES:
            local, source = next(iter(self._sizes[site]))
            self.forgotten += 1
            text = "not all latched messages of site %s are kept for later subscribers: they have more than %s MB"
            self._node.log.peer_event(WARN, text, site, LATCHED_BYTES >> 20)
            self._note_size(local, source, None)
            # The topic has another publisher, so this does not wait for the master.
            self._topics[local].latched.pop(source).unregister()

    def subscribed_topics(self, bridges: Collection[str]) -> frozenset[str]:
        """Return the topics to which nodes other than bridges subscribe."""
        with self._lock:
            topics = [*self._topics.items()]
        return frozenset(
            local for local, topic in topics if any(link.peer not in bridges for link in topic.publisher.links)
        )

    def close(self) -> None:
        """Stop publishing."""
        for local in [*self._topics]:
            self.withdraw(local)
