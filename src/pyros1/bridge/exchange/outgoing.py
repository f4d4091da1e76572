"""A topic that a site sends: its receivers, the numbers of its messages, and those kept for resending. No I/O.

Messages are numbered without gaps, so receivers notice what they missed. What is kept depends on the topic:

- latched: the last message of each publisher that latches, until the publisher is gone;
- reliable: all messages that are not too old, within bounds;
- others: nothing, since the next message replaces what was lost.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from typing import NamedTuple

from pyros1.bridge.protocol.packets import (
    MAX_NUMBERS,
    Flag,
    LatchedList,
    MessageHead,
    OfferedTopic,
    ResendRequest,
    Tail,
)
from pyros1.bridge.rules.rules import Settings

HISTORY_BYTES = 8 << 20
"""Maximum total size in bytes of the messages kept for a reliable topic; at least one is kept."""
HISTORY_MESSAGES = 2_000
"""Maximum number of messages kept for a reliable topic."""


class ReceivedMessage(NamedTuple):
    """A message that a site's bridge has received from its publisher.

    Attributes:
        publisher: the publisher's name.
        md5sum: md5 sum of its type.
        latched: whether the publisher latches it.
        body: the encoded message.
        uri: the URI of the publisher's node; empty if it is not known, or not needed, as the message is not latched.
    """

    publisher: str
    md5sum: str
    latched: bool
    body: bytes
    uri: str = ""


class NumberedMessage(NamedTuple):
    """A message with its head, ready to be sent."""

    head: MessageHead
    body: bytes


class DropReason:
    """The reasons why messages are not sent or not delivered, as shown by the status."""

    RATE = "over the rate limit"
    SIZE = "too large"
    TYPE = "with a different md5sum"
    BRIDGED = "came over a bridge"
    OLD = "too old"
    EARLY = "published before anyone here subscribed"
    REPEATED = "repeated"
    OVERTAKEN = "replaced by newer ones"
    MISSED = "lost"
    PUBLISHERS = "from too many publishers"
    DAMAGED = "not messages of their type"
    UNCONVERTED = "could not be converted"
    QUEUE = "queue full, since the network is too slow"


class OutgoingTopic:
    """A topic that is offered to other sites.

    Args:
        offered: how it is offered; all but its name may change.
        settings: how its messages are sent.
        epoch: this site's epoch.

    Attributes:
        topic: its name among sites.
        requests: the sites that want it, and each one's rate; 0 for all messages. See `set_requests`.
        last: the number of the last message.
    """

    def __init__(self, offered: OfferedTopic, settings: Settings, epoch: int) -> None:
        self.offered = offered
        self.settings = settings
        self.last = 0
        self.topic = offered.topic
        self.requests: Mapping[str, float] = {}
        self._before: dict[str, int] = {}  # site -> the last message before its request
        self._period = 1.0 / settings.rate if settings.rate else None
        self._epoch = epoch
        self._publishers: dict[str, int] = {}
        self._first_received_at: dict[str, float] = {}
        self._next_publisher = 1
        self._due: dict[str, float] = {}  # publisher -> when its next message may be sent
        self._waiting: dict[str, tuple[ReceivedMessage, float]] = {}  # latched messages over the rate limit
        self._latched: dict[str, NumberedMessage] = {}
        self._history: deque[NumberedMessage] = deque()
        self._history_bytes = 0

    def set_requests(self, requests: Mapping[str, float]) -> None:
        """Set `requests`, from now on."""
        self.requests = requests
        self._before = {site: self._before.get(site, self.last) for site in requests}
        limits = [self.settings.rate] if self.settings.rate else []
        if requests and all(requests.values()):
            limits.append(max(requests.values()))
        self._period = 1.0 / min(limits) if limits else None  # between messages of a publisher; None: no limit

    @property
    def is_lossless(self) -> bool:
        """Whether heartbeats contain the number of the last message, so that receivers notice what they missed."""
        return self.offered.latched or self.offered.reliable

    def tail(self, site: str) -> Tail:
        """Return where the topic ends for a site that has requested it."""
        return Tail(self.last, self._before[site])

    def take(self, received: ReceivedMessage, now: float, is_repeated: bool = False) -> NumberedMessage | str:
        """Return a message with its number, to be sent to all sites that want the topic; or why it is dropped.

        Args:
            received: the message.
            now: the current time in seconds.
            is_repeated: whether its publisher has sent it again because it is latched; a command is then dropped.
        """
        if is_repeated and not self.settings.may_latch:
            return DropReason.REPEATED
        if received.md5sum != self.offered.md5sum:
            return DropReason.TYPE
        if len(received.body) > self.settings.max_size:
            return DropReason.SIZE
        if not self._may_send(received.publisher, now):
            if received.latched and self.offered.latched:  # the last one must arrive in the end
                self._waiting[received.publisher] = (received, now)
            return DropReason.RATE
        self._waiting.pop(received.publisher, None)
        return self._number(received, now)

    def is_due(self, received: ReceivedMessage, now: float) -> bool:
        """Return whether `take` would send a message now, or keep it for later: if not, it need not be converted."""
        period = self._period
        is_kept = received.latched and self.offered.latched
        return period is None or is_kept or self._next_due(received.publisher, period, now)[1]

    def _next_due(self, publisher: str, period: float, now: float) -> tuple[float, bool]:
        """Return when another message of a publisher is due after this one, and whether this one is due."""
        due = self._due.get(publisher, now)
        if due > now + 1.2 * period:  # a lower rate was wanted before
            return now + period, False
        # A message that is a little early counts as the due one: publishers are not exact.
        if now < due - 0.1 * period:
            return due, False
        return max(due, now - period) + period, True

    def _may_send(self, publisher: str, now: float) -> bool:
        period = self._period
        if period is None:
            return True
        self._due[publisher], is_due = self._next_due(publisher, period, now)
        return is_due

    def _number(self, received: ReceivedMessage, now: float) -> NumberedMessage | str:
        publisher = self._publishers.get(received.publisher)
        if publisher is None:
            if len(self._publishers) >= MAX_NUMBERS:
                return DropReason.PUBLISHERS
            publisher = self._publishers[received.publisher] = self._next_publisher
            self._next_publisher += 1
            self._first_received_at[received.publisher] = now
        self.last += 1
        flags = Flag.LATCHED if received.latched and self.offered.latched else 0
        head = MessageHead(self._epoch, 0, self.last, publisher, now, flags, received.md5sum)
        message = NumberedMessage(head, received.body)
        if received.latched and self.settings.may_latch:  # even if the topic does not count as latched yet
            latched_head = head._replace(flags=Flag.LATCHED)
            self._latched[received.publisher] = NumberedMessage(latched_head, received.body)
        if self.offered.reliable and not self.offered.latched:
            self._remember(message)
        return message

    def _remember(self, message: NumberedMessage) -> None:
        self._history.append(message)
        self._history_bytes += len(message.body)
        while len(self._history) > 1 and (self._history_bytes > HISTORY_BYTES or len(self._history) > HISTORY_MESSAGES):
            self._history_bytes -= len(self._history.popleft().body)

    def due(self, now: float) -> list[NumberedMessage]:
        """Return the latched messages that were held back by the rate limit and may be sent now; forget messages that
        are too old.
        """
        age = self.settings.age
        while self._history and now - self._history[0].head.received_at > age:
            self._history_bytes -= len(self._history.popleft().body)
        ready = []
        for publisher, (received, received_at) in list(self._waiting.items()):
            if self._may_send(publisher, now):
                del self._waiting[publisher]
                message = self._number(received, received_at)
                if not isinstance(message, str):
                    ready.append(message)
        return ready

    def drop_publishers(self, gone: list[str], now: float) -> list[NumberedMessage]:
        """Remove publishers; return notices that those with latched messages are gone."""
        notes = []
        for name in gone:
            notes += self.withdraw_latched(name, now)
            self._due.pop(name, None)
            self._publishers.pop(name, None)
            self._first_received_at.pop(name, None)
        return notes

    def withdraw_latched(self, publisher: str, now: float) -> list[NumberedMessage]:
        """Discard a publisher's latched message, which is no longer valid: the publisher is gone, or its next message
        cannot be sent. Return the notice to send to other sites, if they may have the message.
        """
        self._waiting.pop(publisher, None)
        latched = self._latched.pop(publisher, None)
        if latched is None or not self.offered.latched:
            return []
        self.last += 1
        number = latched.head.publisher
        head = MessageHead(self._epoch, 0, self.last, number, now, Flag.LEFT, self.offered.md5sum)
        return [NumberedMessage(head, b"")]

    def gone_publishers(self, registered: Collection[str], asked_at: float) -> list[str]:
        """Return the publishers that have sent messages, but are gone.

        Args:
            registered: the publishers that the master knows.
            asked_at: when the master was asked. A publisher whose first message came later may be new; one whose first
                message came earlier was registered before, even if only for a moment.
        """
        return [
            name for name in self._publishers if name not in registered and self._first_received_at[name] < asked_at
        ]

    def latched_list(self) -> tuple[list[NumberedMessage], LatchedList]:
        """Return the latched messages, and the list of them."""
        messages = [*self._latched.values()]
        numbers = {message.head.publisher: message.head.number for message in messages}
        return messages, LatchedList(self.topic, self.last, numbers)

    def copy_latched(self, other: OutgoingTopic) -> None:
        """Copy the latched messages of another topic with the same publishers, which do not publish them again."""
        newest = {name: (message.body, message.head.received_at) for name, message in other._latched.items()}
        newest |= {name: (received.body, received_at) for name, (received, received_at) in other._waiting.items()}
        for name, (body, received_at) in newest.items():
            received = ReceivedMessage(name, other.offered.md5sum, True, body)
            if received.md5sum == self.offered.md5sum and len(body) <= self.settings.max_size:
                self._number(received, received_at)

    def resend(self, missed: ResendRequest) -> tuple[list[NumberedMessage], int]:
        """Return the messages that a site missed, as far as they are kept, and the number of the first message kept."""
        first_kept = self._history[0].head.number if self._history else self.last + 1
        found = [message for message in self._history if missed.first <= message.head.number <= missed.last]
        return found[:MAX_NUMBERS], first_kept

    def forget_all(self) -> None:
        """Discard all messages, since no site wants the topic now."""
        self._history.clear()
        self._history_bytes = 0
        self._latched.clear()
        self._waiting.clear()
