"""How much a bridge to ROS 2 has exchanged, for its status."""

from __future__ import annotations

import threading

from pyros1.bridge.exchange.sending import Flow

MAX_TOPICS = 25_000
"""Maximum number of topics of each side whose counts are kept: more than there can be at a time."""


class Counts:
    """Counts messages by topic. May be used in several threads."""

    def __init__(self) -> None:
        self._sent: dict[str, Flow] = {}
        self._received: dict[str, Flow] = {}
        self._lock = threading.Lock()

    def to_ros2(self, topic: str) -> Flow:
        """Return what was sent of a topic of ROS 1."""
        with self._lock:
            return _flow(self._sent, topic)

    def to_ros1(self, topic: str) -> Flow:
        """Return what came of a topic of ROS 2."""
        with self._lock:
            return _flow(self._received, topic)


def _flow(flows: dict[str, Flow], topic: str) -> Flow:
    """Return the counts of a topic. For a new one, the oldest is forgotten if there are too many."""
    if topic not in flows and len(flows) >= MAX_TOPICS:
        del flows[next(iter(flows))]
    return flows.setdefault(topic, Flow())
