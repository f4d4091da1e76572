"""Recognises commands that latching publishers repeat when a bridge subscribes again. No I/O.

ROS sends a latching publisher's last message to each new connection. A bridge subscribes to a topic only while another
site requests it, so after a long outage, or after the other site's restart, it would get the last command again, and
would send it as a new one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

from pyros1.bridge.conversions.conversion import Conversion

Source = tuple[str, Conversion | None]
"""A topic of this site's master, and how its messages are converted. The bridge subscribes once for each."""
_MAX_PUBLISHERS = 1_000
"""Maximum number of latching publishers of a topic that are remembered, the newest ones."""


class _Publisher(NamedTuple):
    uri: str  # a node that was killed and started again has another one
    since: float  # when its first message was received


class LatchedRepeats:
    """The latching publishers whose messages the bridge has received."""

    def __init__(self) -> None:
        self._heard: dict[Source, dict[str, _Publisher]] = {}
        self._repeating: dict[Source, set[str]] = {}  # the publishers whose next message is a repetition

    def on_subscribe(self, source: Source) -> None:
        """Record that the bridge subscribes again: the publishers heard before will repeat their last messages."""
        if heard := self._heard.get(source):
            self._repeating[source] = {*heard}

    def take(self, source: Source, publisher: str, uri: str, now: float) -> bool:
        """Record a message of a latching publisher, and return whether it is a repetition: either of a message that the
        bridge has received, or of one from the time when no other site requested the topic.

        Args:
            source: the topic and its conversion.
            publisher: the publisher's name.
            uri: the URI of its node; empty if it is not known.
            now: the current time in seconds.
        """
        heard = self._heard.setdefault(source, {})
        known = heard.get(publisher)
        is_other = known is not None and "" not in (uri, known.uri) and uri != known.uri
        if publisher in self._repeating.get(source, ()):
            self._repeating[source].remove(publisher)
            if not is_other:
                return True
        if known is None and len(heard) >= _MAX_PUBLISHERS:
            del heard[next(iter(heard))]
        if known is None or is_other:
            heard[publisher] = _Publisher(uri, now)
        return False

    def drop_publishers(self, registered: Mapping[str, Collection[str]], asked_at: float) -> None:
        """Forget the publishers that are gone; later ones may have the same names.

        Args:
            registered: topic -> the nodes that the master lists as its publishers.
            asked_at: when the master was asked, in seconds. A publisher that was first heard later may be new.
        """
        for source, heard in [*self._heard.items()]:
            known = registered.get(source[0], ())
            for publisher in [name for name, each in heard.items() if each.since < asked_at and name not in known]:
                del heard[publisher]
                self._repeating.get(source, set()).discard(publisher)
            if not heard:
                del self._heard[source]
                self._repeating.pop(source, None)
