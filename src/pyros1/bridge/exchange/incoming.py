"""A topic that is received from another site, and its status. No I/O."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pyros1.bridge.conversions.prefixes import Prefixer
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.exchange.streams import Stream
from pyros1.bridge.exchange.topic_sender import Flow
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import OfferedTopic
from pyros1.bridge.rules.rules import Settings

_MAX_PUBLISHERS = 1_000
"""Maximum number of publishers of a topic whose rates are limited."""


class IncomingTopic:
    """A topic that another site offers and that a rule takes.

    Args:
        offered: how it is offered.
        settings: how its messages are received.
        stream: their order.
        prefixer: what is put before names in them.

    Attributes:
        flow: what came, and what was dropped.
        is_wanted: whether it is requested, since somebody subscribes to it here.
        wanted_since: since when, in seconds.
        is_paused: whether it was wanted when its site was lost; then it is requested again after its return, until
            `paused_until`.
    """

    def __init__(self, offered: OfferedTopic, settings: Settings, stream: Stream, prefixer: Prefixer) -> None:
        self.offered = offered
        self.settings = settings
        self.stream = stream
        self.flow = Flow()
        self.is_wanted = False
        self.wanted_since = 0.0
        self.is_paused = False
        self.paused_until = float("inf")
        self.prefixer = prefixer
        self._due: dict[int, float] = {}  # publisher -> when its next message may be delivered

    def reason_to_limit(self, publisher: int, now: float) -> str | None:
        """Return why a message must be dropped because of the topic's rate; None if it is delivered."""
        if not self.settings.rate:
            return None
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
        topic, type, local: its name among sites, its message type, its name here; the latter is empty if it is refused.
        state: whether it is wanted, or why it is not taken.
        flow: what came, and what was dropped.
        missed_drops: the messages that the order of delivery has cost.
        publishers: the nodes at the other site that publish it.
    """

    peer: str
    topic: SharedName
    type: str
    local: str
    state: str
    flow: Flow
    missed_drops: Mapping[str, int]
    publishers: tuple[str, ...] = ()
