"""The ROS 2 publishers whose last messages a bridge keeps latched in ROS 1, until they are gone. No I/O.

A message names its publisher by a GID. Another bridge derives its GIDs from tokens, so their publishers are known.
rmw_zenoh derives them differently, but zenoh tells which session a latched publisher's message is from. Such a message
is kept as long as that session, which is usually one program, has any latched publisher of the topic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import count
from typing import NamedTuple

from pyros1.bridge.exchange.actions import Source
from pyros1.bridge.names import SharedName
from pyros1.ros2.bridge.services import SITE
from pyros1.ros2.zenoh.tokens import Entity, gid

MAX_SOURCES = 1000
"""Maximum number of latched ROS 2 publishers that are distinguished, plus topics that are not latched."""
GRACE = 2.0
"""Minimum seconds for which a message is kept, since it may come before its publisher's token or after its removal."""
Tokens = Mapping[str, Entity]
"""The current publishers of a topic, by their tokens."""


class _Publisher:
    def __init__(self, source: Source, session: str) -> None:
        self.source = source
        self.session = session
        self.was_found = False  # whether its token was ever seen
        self.at = 0.0


class GoneSource(NamedTuple):
    """A publisher whose message is no longer kept."""

    topic: str
    source: Source


class Ros2Publishers:
    """The publishers in ROS 2 whose messages have been received, each with its key in ROS 1. Not thread-safe.

    Attributes:
        must_check: whether to call `pop_gone` even if no publisher has disappeared since its last call.
    """

    def __init__(self) -> None:
        self.must_check = False
        self._publishers: dict[tuple[str, bytes], _Publisher] = {}
        self._numbers = count(1)

    def get(self, topic: str, gid: bytes, session: str, now: float) -> tuple[Source, GoneSource | None]:
        """Return the key of a publisher. If there are too many, also return the one dropped to make room: the one that
        has been silent for the longest time.

        Args:
            topic: its topic.
            gid: its GID; empty if messages are not kept.
            session: the id of its session in zenoh; empty if it is not known.
            now: the time in seconds.
        """
        publisher, gone = self._publishers.pop((topic, gid), None), None
        if publisher is None:
            self.must_check = True
            publisher = _Publisher(Source(SITE, SharedName(SITE, topic), next(self._numbers)), session)
            if len(self._publishers) >= MAX_SOURCES:
                oldest = next(iter(self._publishers))
                gone = GoneSource(oldest[0], self._publishers.pop(oldest).source)
        publisher.at = now
        self._publishers[topic, gid] = publisher
        return publisher.source, gone

    def pop_gone(self, tokens_of: Callable[[str], Tokens], now: float) -> Iterator[GoneSource]:
        """Forget the publishers that are gone, and yield them.

        Args:
            tokens_of: returns a topic's current publishers.
            now: the time in seconds.
        """
        topics = {topic for topic, own_gid in self._publishers if own_gid}
        there = {topic: _latched(tokens_of(topic)) for topic in topics}
        self.must_check = False
        for (topic, own_gid), publisher in [*self._publishers.items()]:
            if not own_gid or not self._is_gone(own_gid, publisher, *there[topic]):
                continue
            if now - publisher.at < GRACE:
                self.must_check = True
                continue
            del self._publishers[topic, own_gid]
            yield GoneSource(topic, publisher.source)

    def _is_gone(self, own_gid: bytes, publisher: _Publisher, gids: set[bytes], sessions: set[str]) -> bool:
        if own_gid in gids:
            publisher.was_found = True
            return False
        return not sessions or publisher.was_found or bool(publisher.session and publisher.session not in sessions)


def _latched(tokens: Tokens) -> tuple[set[bytes], set[str]]:
    """Return the GIDs and sessions of latched publishers."""
    latched = {token: entity for token, entity in tokens.items() if entity.qos.transient_local}
    return {*map(gid, latched)}, {entity.zid for entity in latched.values()}
