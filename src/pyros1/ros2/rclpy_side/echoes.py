"""Recognises messages that come back from our own publishers: unlike zenoh, rclpy cannot filter them out.

Newer versions of rclpy (since Kilted) tell which publisher sent a message. With older ones, a message counts
as our own if it has the same bytes as one that was just sent.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from hashlib import blake2b

MAX_GIDS = 10_000
MAX_SENT = 1_000
"""Maximum number of messages per topic that are remembered until they come back."""


class Echoes:
    """The messages that were sent, and their publishers. May be used in several threads.

    Args:
        look_up: returns the identifiers of a topic's publishers, and whether each belongs to this bridge.
        tells_publishers: whether this version of rclpy names a message's publisher. Some middleware still does not,
            which the first message shows.
    """

    def __init__(self, look_up: Callable[[str], Mapping[bytes, bool]], tells_publishers: bool) -> None:
        self._look_up = look_up
        self._tells_publishers = tells_publishers
        self._gids: dict[bytes, bool] = {}
        self._sent: dict[str, OrderedDict[bytes, int]] = {}
        self._lock = threading.Lock()

    def set_topics(self, topics: set[str]) -> None:
        """Look for our own messages on exactly these topics from now on.

        Args:
            topics: the topics that we both publish and subscribe to.
        """
        with self._lock:
            self._sent = {topic: self._sent.get(topic, OrderedDict()) for topic in topics}

    def on_send(self, topic: str, body: bytes) -> None:
        """Record that a message is about to be sent."""
        if self._tells_publishers or topic not in self._sent:
            return
        digest = _digest(body)
        with self._lock:
            sent = self._sent.get(topic)
            if sent is not None:
                sent[digest] = sent.pop(digest, 0) + 1
                if len(sent) > MAX_SENT:
                    sent.popitem(last=False)

    def is_echo(self, topic: str, body: bytes, gid: bytes) -> bool:
        """Return whether a message comes from one of our own publishers.

        Args:
            topic, body: the message.
            gid: the identifier of its publisher; empty if rclpy does not provide it.
        """
        if gid:
            return self._is_own(topic, gid)
        self._tells_publishers = False
        if topic not in self._sent:
            return False
        digest = _digest(body)
        with self._lock:
            sent = self._sent.get(topic, OrderedDict())
            times = sent.pop(digest, 0)
            if times > 1:
                sent[digest] = times - 1
        return times > 0

    def _is_own(self, topic: str, gid: bytes) -> bool:
        is_own = self._gids.get(gid)
        if is_own is None:
            if len(self._gids) >= MAX_GIDS:
                self._gids = {}
            self._gids.update(self._look_up(topic))
            is_own = self._gids.get(gid, False)
        return is_own


def _digest(body: bytes) -> bytes:
    return blake2b(body, digest_size=16).digest()
