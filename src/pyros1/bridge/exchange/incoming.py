"""A topic that is received from another site, and its status. No I/O."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pyros1.bridge.conversions.prefixes import Prefixer
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.exchange.streams import Stream
from pyros1.bridge.exchange.topic_sender import TopicCounts
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import OfferedTopic
from pyros1.bridge.rules.rules import Settings

_MAX_PUBLISHERS = 1_000
"""Maximum number of publishers of a topic whose rates are limited."""


class IncomingTopic:
    """A topic that another site offers and a rule accepts.

    Args:
        offered: how it is offered.
        settings: how its messages are received.
        stream: puts them in order.
        prefixer: adds prefixes to the names in them.

    Attributes:
        flow: counts of its delivered and dropped messages.
        is_wanted: whether it is requested, since a local node subscribes to it.
        wanted_since: the time in seconds since which it is wanted.
        is_paused: whether it was wanted when its site was lost; the request is then kept until `paused_until`, some
            time after the site's return.
    """

    def __init__(self, offered: OfferedTopic, settings: Settings, stream: Stream, prefixer: Prefixer) -> None:
        self.offered = offered
        self.settings = settings
        self.stream = stream
        self.flow = TopicCounts()
        self.is_wanted = False
        self.wanted_since = 0.0
        self.is_paused = False
        self.paused_until = float("inf")
        self.prefixer = prefixer
        self._due: dict[int, float] = {}  # publisher -> when its next message may be delivered

    def reason_to_limit(self, publisher: int, now: float) -> str | None:
        """Return why a message of a topic with a limited rate must be dropped; None if it may be delivered."""
        assert self.settings.rate
        period = 1.0 / self.settings.rate
        if publisher not in self._due and len(self._due) >= _MAX_PUBLISHERS:
            self._due = {each: due for each, due in self._due.items() if due > now}
            if len(self._due) >= _MAX_PUBLISHERS:
                return DropReason.PUBLISHERS
        due = self._due.get(publisher, now)
        if now < due - 0.1 * period:
            return DropReason.RATE
        self._due[publisher] = max(due, now - period) + period
        return None


class ReceivedTopic(NamedTuple):
    """A topic of another site, for the status.

    Attributes:
        peer: the site that offers it.
        topic, type, local: its name between sites, its message type, its local name; the latter is empty if the topic
            is refused.
        state: whether it is wanted, or why it is refused.
        flow: what came, and what was dropped.
        missed_drops: the messages that its stream dropped, by reason.
        publishers: the nodes at the other site that publish it.
    """

    peer: str
    topic: SharedName
    type: str
    local: str
    state: str
    flow: TopicCounts
    missed_drops: Mapping[str, int]
    publishers: tuple[str, ...] = ()
