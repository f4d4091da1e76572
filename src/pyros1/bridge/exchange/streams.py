"""The receiving end of a topic between sites: orders messages, drops duplicates, and detects gaps.

There is one stream for each topic of each run of a site. Packets may arrive late, twice, out of order, or never. Every
stream guarantees that no message is delivered twice, or after a later one from the same publisher. They differ in what
they do about a gap in the numbers:

- `NewestStream` continues with the later message;
- `ReliableStream` holds back later messages, requests the missed ones, and continues without them only when the sender
  says that it no longer has them, or when they would be too old. It begins where the sender says, so that the first
  messages are not missed either;
- `LatchedStream` delivers at once, since only each publisher's last message counts, and compares its messages with
  those that the sender holds.

No I/O. All times are in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.protocol.packets import MAX_NUMBERS, Flag, LatchedList, MessageHead, ResendRefusal, Tail

_FIRST_RETRY = 0.5
_LAST_RETRY = 8.0
"""Initial and maximum seconds between requests for the same missed messages: on a slow network the responses to earlier
requests may still be in transit."""
_BUFFER_MESSAGES = 2_000
_BUFFER_BYTES = 8 << 20
"""Maximum number and total size in bytes of the messages held back until missed ones arrive."""
SITE_BUFFER_BYTES = 64 << 20
"""Maximum total size in bytes of the messages of all topics of a site that are held back."""
MESSAGE_COST = 500
"""Approximate bytes that a held-back message takes besides its body, which may be empty."""
_FIRST_WAIT = 2.0
"""Seconds to wait for missed messages if their age is not limited."""


class Delivery(NamedTuple):
    """A message to deliver, or a notice that a publisher's latched message is withdrawn (`body` is None)."""

    head: MessageHead
    body: bytes | None


class Stream(Protocol):
    """The interface of all streams.

    Attributes:
        drops: how many messages were dropped for each reason.
        highest: the highest number received.
    """

    drops: dict[str, int]
    highest: int

    def restart(self, now: float) -> None:
        """Restart after the topic was not wanted for a while; messages delivered before are not repeated."""
        ...

    def accept(self, head: MessageHead, body: bytes, now: float) -> list[Delivery]:
        """Handle a message; return the deliveries."""
        ...

    def on_tail(self, tail: Tail, now: float) -> list[Delivery]:
        """Record where the topic ends; return the deliveries."""
        ...

    def missed(self, now: float) -> tuple[int, int] | None:
        """Return the numbers of the first and last message to request now; None if there are none."""
        ...

    def tick(self, now: float) -> list[Delivery]:
        """Stop waiting for messages that are overdue; return the deliveries."""
        ...

    def on_gone(self, gone: ResendRefusal, now: float) -> list[Delivery]:
        """Handle a refusal to resend some messages; return the deliveries."""
        ...

    def on_latched_list(self, latched_list: LatchedList) -> list[Delivery]:
        """Handle the site's list of latched messages; return the deliveries."""
        ...


class BufferedBytes:
    """The number of bytes that a site's streams hold back."""

    def __init__(self) -> None:
        self.total = 0


class _Questions:
    """Decides when to ask for missed messages.

    Args:
        asked_at: when they were last asked for; None if never.
    """

    def __init__(self, asked_at: float | None = None) -> None:
        self._asked_at = float("-inf") if asked_at is None else asked_at
        self._period = 0.0 if asked_at is None else _FIRST_RETRY

    def is_due(self, now: float) -> bool:
        """Return whether to ask now; if so, record the request."""
        if now - self._asked_at < self._period:
            return False
        self._period = min(_LAST_RETRY, max(_FIRST_RETRY, 2 * self._period))
        self._asked_at = now
        return True

    def on_progress(self) -> None:
        """Make the next request due soon, since requested messages are arriving."""
        self._period = min(self._period, _FIRST_RETRY)


class _CountingStream:
    def __init__(self, floor: int) -> None:
        self.drops: dict[str, int] = {}
        self.highest = floor

    def count(self, reason: str, number: int = 1) -> list[Delivery]:
        """Count dropped messages; return no deliveries."""
        self.drops[reason] = self.drops.get(reason, 0) + number
        return []


class NewestStream(_CountingStream):
    """Delivers each message that is newer than all earlier ones.

    Args:
        floor: messages up to this number are not delivered.
    """

    def __init__(self, floor: int) -> None:
        super().__init__(floor)

    def restart(self, now: float) -> None:
        """Do nothing: later messages have higher numbers."""

    def accept(self, head: MessageHead, body: bytes, now: float) -> list[Delivery]:
        """See `Stream`."""
        if head.number <= self.highest:
            return self.count(DropReason.REPEATED if head.number == self.highest else DropReason.OVERTAKEN)
        self.highest = head.number
        return [Delivery(head, body)]

    def on_tail(self, tail: Tail, now: float) -> list[Delivery]:
        """Return an empty list: missed messages are not requested."""
        return []

    def missed(self, now: float) -> tuple[int, int] | None:
        """Return None: missed messages are not requested."""
        return None

    def tick(self, now: float) -> list[Delivery]:
        """Return an empty list: no messages are held back."""
        return []

    def on_gone(self, gone: ResendRefusal, now: float) -> list[Delivery]:
        """Return an empty list: no messages are held back."""
        return []

    def on_latched_list(self, latched_list: LatchedList) -> list[Delivery]:
        """Return an empty list: no message is latched."""
        return []


class ReliableStream(_CountingStream):
    """Delivers all messages in order.

    Args:
        age: maximum age of a message in seconds; None for no limit. The stream waits for missed messages until they
            would be too old.
        floor: messages up to this number are not delivered.
        site: counts the bytes that all of the site's streams hold back.
    """

    def __init__(self, age: float | None, floor: int, site: BufferedBytes | None = None) -> None:
        super().__init__(floor)
        self._site = site or BufferedBytes()
        self._patience = _FIRST_WAIT if age is None else age
        self._last: int | None = None  # last number delivered or given up; None while the beginning is not known
        self._floor = floor
        self._tail = 0
        self._waiting: dict[int, Delivery] = {}
        self._waiting_bytes = 0
        self._gap_since: float | None = None
        self._questions = _Questions()

    def restart(self, now: float) -> None:
        """See `Stream`."""
        self._questions = _Questions()
        self._floor = max(self.highest, self._last or 0)
        self._last, self._tail, self._gap_since = None, 0, None
        self._waiting.clear()
        self._buffer(-self._waiting_bytes)

    def _buffer(self, size: int) -> None:
        """Record how many more bytes are held back."""
        self._waiting_bytes += size
        self._site.total += size

    def accept(self, head: MessageHead, body: bytes, now: float) -> list[Delivery]:
        """See `Stream`. The first messages wait until the sender has said where the topic begins."""
        number = head.number
        if number <= (self._floor if self._last is None else self._last) or number in self._waiting:
            return self.count(DropReason.REPEATED)
        self._waiting[number] = Delivery(head, body)
        self._buffer(MESSAGE_COST + len(body))
        self._tail = max(self._tail, number)
        self.highest = max(self.highest, number)
        deliveries = self._take_ready(now)
        while (
            len(self._waiting) > _BUFFER_MESSAGES
            or self._waiting_bytes > _BUFFER_BYTES
            or self._site.total > SITE_BUFFER_BYTES
        ):
            deliveries += self._give_up(min(self._waiting), now)
        return deliveries

    def _take_ready(self, now: float) -> list[Delivery]:
        if self._last is None:
            self._gap_since = now if self._gap_since is None else self._gap_since
            return []
        ready = []
        while (delivery := self._waiting.pop(self._last + 1, None)) is not None:
            self._last += 1
            self._questions.on_progress()
            self._buffer(-_cost(delivery))
            ready.append(delivery)
        if self._tail <= self._last:
            self._gap_since = None
        elif ready or self._gap_since is None:
            self._gap_since = now
        return ready

    def _give_up(self, next_number: int, now: float) -> list[Delivery]:
        """Continue with a number, skipping the missed messages before it."""
        if self._last is None:
            self._last = next_number - 1
        skipped = sum(number < next_number for number in self._waiting)
        if (missed := next_number - 1 - self._last - skipped) > 0:
            self.count(DropReason.MISSED, missed)
        before = [self._waiting.pop(number) for number in sorted(self._waiting) if number < next_number]
        self._buffer(-sum(map(_cost, before)))
        self._last = max(self._last, next_number - 1)
        self._gap_since = None
        return before + self._take_ready(now)

    def on_tail(self, tail: Tail, now: float) -> list[Delivery]:
        """See `Stream`."""
        ready = []
        if self._last is None:
            self._last = max(tail.before, self._floor)
            for number in [number for number in self._waiting if number <= self._last]:  # they were sent to others
                self._buffer(-_cost(self._waiting.pop(number)))
            ready = self._take_ready(now)
        self._tail = max(self._tail, tail.last)
        if self._tail > self._last and self._gap_since is None:
            self._gap_since = now
        return ready

    def missed(self, now: float) -> tuple[int, int] | None:
        """See `Stream`."""
        if self._last is None or self._tail <= self._last or not self._questions.is_due(now):
            return None
        first_waiting = min(self._waiting, default=self._tail + 1)
        return self._last + 1, min(first_waiting - 1, self._last + MAX_NUMBERS)

    def tick(self, now: float) -> list[Delivery]:
        """See `Stream`."""
        if self._gap_since is None or now - self._gap_since <= self._patience:
            return []
        return self._give_up(min(self._waiting, default=self._tail + 1), now)

    def on_gone(self, gone: ResendRefusal, now: float) -> list[Delivery]:
        """See `Stream`."""
        if self._last is None or not self._last + 1 < gone.first <= self._tail + 1:
            return []
        return self._give_up(gone.first, now)

    def on_latched_list(self, latched_list: LatchedList) -> list[Delivery]:
        """Return an empty list: no message is latched."""
        return []


def _cost(delivery: Delivery) -> int:
    return MESSAGE_COST + len(delivery.body or b"")


class LatchedStream(_CountingStream):
    """Delivers the last message of each publisher, and reports publishers that are gone.

    Args:
        floor: messages up to this number are not delivered, unless they are latched.
    """

    def __init__(self, floor: int) -> None:
        super().__init__(floor)
        self._floor = floor
        self._newest: dict[int, int] = {}  # publisher -> number of its last message or note
        self._present: set[int] = set()  # the publishers with a valid latched message
        self._synced = -1  # nothing up to this number is missing
        self._listed_to = 0  # up to this number, only messages in the newest list are valid
        self._listed: Mapping[int, int] = {}
        self._tail = 0
        self._questions = _Questions()

    def restart(self, now: float) -> None:
        """See `Stream`. Latched messages are delivered again, since the earlier subscribers are gone."""
        for publisher in self._present:
            self._newest[publisher] -= 1
        self._present.clear()
        self._synced, self._questions = -1, _Questions(now)  # the sender answers with all messages that it holds

    def accept(self, head: MessageHead, body: bytes, now: float) -> list[Delivery]:
        """See `Stream`."""
        publisher, number = head.publisher, head.number
        self._tail = max(self._tail, number)
        self.highest = max(self.highest, number)
        # A latched message is valid even if it was delivered before the topic was offered as latched.
        known = self._newest.get(publisher, 0 if head.flags & Flag.LATCHED else self._floor)
        if number == self._synced + 1:
            self._synced = number
        if number <= known:
            return self.count(DropReason.REPEATED if number == known else DropReason.OVERTAKEN)
        if number <= self._listed_to and self._listed.get(publisher) != number:
            return self.count(DropReason.OVERTAKEN)  # its publisher has sent another one, or is gone
        if publisher not in self._newest and len(self._newest) >= MAX_NUMBERS:
            self._forget_gone()
            if len(self._newest) >= MAX_NUMBERS:
                return self.count(DropReason.PUBLISHERS)
        self._newest[publisher] = number
        self._questions.on_progress()
        if not head.flags & Flag.LEFT:
            if head.flags & Flag.LATCHED:
                self._present.add(publisher)
            return [Delivery(head, body)]
        if publisher not in self._present:
            return []
        self._present.remove(publisher)
        return [Delivery(head, None)]

    def _forget_gone(self) -> None:
        """Forget publishers that left so long ago that none of their messages can still arrive."""
        for publisher in [each for each in self._newest if each not in self._present][: MAX_NUMBERS // 2]:
            del self._newest[publisher]

    def on_tail(self, tail: Tail, now: float) -> list[Delivery]:
        """See `Stream`."""
        self._tail = max(self._tail, tail.last)
        return []

    def missed(self, now: float) -> tuple[int, int] | None:
        """See `Stream`. The numbers start after the last one up to which nothing is missing."""
        if self._synced >= self._tail or not self._questions.is_due(now):
            return None
        return self._synced + 1, self._tail

    def tick(self, now: float) -> list[Delivery]:
        """Return an empty list: no messages are held back."""
        return []

    def on_gone(self, gone: ResendRefusal, now: float) -> list[Delivery]:
        """Return an empty list: no messages are held back."""
        return []

    def on_latched_list(self, latched_list: LatchedList) -> list[Delivery]:
        """See `Stream`."""
        self._tail = max(self._tail, latched_list.number)
        if latched_list.number < self._synced:
            return []  # an old list
        self._listed_to, self._listed = latched_list.number, latched_list.messages
        notes = []
        for publisher in sorted(self._present):
            number = self._newest[publisher]
            if publisher not in latched_list.messages and number <= latched_list.number:
                self._present.remove(publisher)
                head = MessageHead(0, 0, latched_list.number, publisher, 0.0, Flag.LEFT, "")
                notes.append(Delivery(head, None))
        if all(self._newest.get(publisher, 0) >= number for publisher, number in latched_list.messages.items()):
            self._synced = max(self._synced, latched_list.number)
        return notes


def make_stream(latched: bool, reliable: bool, age: float | None, floor: int, site: BufferedBytes) -> Stream:
    """Return the stream for a topic.

    Args:
        latched, reliable: whether the site offers it as such.
        age: maximum age of its messages in seconds; None for no limit.
        floor: messages up to this number are not delivered, since they may have been delivered before.
        site: counts the bytes that all of the site's streams hold back.
    """
    if latched:
        return LatchedStream(floor)
    return ReliableStream(age, floor, site) if reliable else NewestStream(floor)
