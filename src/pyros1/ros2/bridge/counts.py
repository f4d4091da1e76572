"""The message counts and rates in the status of a bridge to ROS 2."""

from __future__ import annotations

import threading
from collections.abc import Hashable

from pyros1.bridge.exchange.topic_sender import TopicCounts
from pyros1.bridge.rates import Count, Rate, Rates

MAX_TOPICS = 25_000
"""Maximum number of topics per side whose counts are kept: more than can exist at a time."""


class Counts:
    """Counts messages by topic. May be used in several threads."""

    def __init__(self) -> None:
        self._sent: dict[str, TopicCounts] = {}
        self._received: dict[str, TopicCounts] = {}
        self._rates = Rates()
        self._lock = threading.Lock()

    def to_ros2(self, topic: str) -> TopicCounts:
        """Return the counts of a ROS 1 topic."""
        with self._lock:
            return _flow(self._sent, topic)

    def to_ros1(self, topic: str) -> TopicCounts:
        """Return the counts of a ROS 2 topic."""
        with self._lock:
            return _flow(self._received, topic)

    def sample(self, now: float) -> None:
        """Record the counts for the rates, if it is time. Call this about once per second.

        Args:
            now: the time in seconds.
        """
        with self._lock:
            if self._rates.is_due(now):
                flows: list[tuple[Hashable, TopicCounts]] = [((False, name), flow) for name, flow in self._sent.items()]
                flows += [((True, name), flow) for name, flow in self._received.items()]
                counts = {key: Count(flow.messages, flow.bytes) for key, flow in flows if flow.messages}
                self._rates.add(counts, now)

    def rate_to_ros2(self, topic: str) -> Rate | None:
        """Return the message rate of a ROS 1 topic; None if it is not known yet."""
        with self._lock:
            return self._rates.rate((False, topic))

    def rate_to_ros1(self, topic: str) -> Rate | None:
        """Return the message rate of a ROS 2 topic; None if it is not known yet."""
        with self._lock:
            return self._rates.rate((True, topic))


def _flow(flows: dict[str, TopicCounts], topic: str) -> TopicCounts:
    """Return the counts of a topic. If there are too many topics, a new one replaces the oldest."""
    if topic not in flows and len(flows) >= MAX_TOPICS:
        del flows[next(iter(flows))]
    return flows.setdefault(topic, TopicCounts())
