"""What waits to be sent to a client. Pure, bounded, and safe for threads: a slow client gets the newest messages."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.web.rosbridge.operations import Id, Subscribe

if TYPE_CHECKING:
    from pyros1.web.hub import Arrival

Frame = str | bytes
MOST_MESSAGES = 1000
"""Most messages of a topic that wait."""
MOST_BYTES = 4 << 20
"""Most bytes of a topic's messages that wait; but one may wait, however large."""
MOST_OF_ALL = 32 << 20
"""As `MOST_BYTES`, of all topics."""
MOST_TOLD = 1 << 20
"""Bytes of answers beyond which no more is read from the client."""
_AT_ONCE = 1 << 20
"""Bytes of messages that are taken at a time."""


class Flow:
    """A topic that the client subscribes to.

    Attributes:
        name: the topic, as the client calls it.
        compression, fragment_size: as the client wants its frames.
        end: ends the flow of messages.
        problem: what was wrong with the last message.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.wishes: dict[Id, Subscribe] = {}
        self.end: Callable[[], object] = lambda: None
        self.problem = ""
        self.compression = "none"
        self.fragment_size: int | None = None
        self.waiting: deque[Arrival] = deque()
        self.size = 0
        self.most = MOST_MESSAGES
        self.throttle = 0.0
        self.last: Arrival | None = None
        self.next_time = float("-inf")

    def wish(self, wish: Subscribe) -> None:
        """Add a subscription. The fastest, the longest queue, the smallest frames and the last compression count."""
        self.wishes.pop(wish.key, None)
        self.wishes[wish.key] = wish
        self._weigh()

    def unwish(self, key: Id) -> None:
        """Remove a subscription, or all."""
        if key is None:
            self.wishes.clear()
        else:
            self.wishes.pop(key, None)
        if self.wishes:
            self._weigh()

    def _weigh(self) -> None:
        wishes = list(self.wishes.values())
        throttle = min(wish.throttle for wish in wishes)
        self.next_time += throttle - self.throttle
        self.throttle = throttle
        length = max(wish.queue_length for wish in wishes)
        self.most = min(length, MOST_MESSAGES) or (1 if throttle else MOST_MESSAGES)
        self.fragment_size = min((wish.fragment_size for wish in wishes if wish.fragment_size), default=None)
        self.compression = wishes[-1].compression

    def due(self) -> float | None:
        """Return when the next message may be sent; None: none waits."""
        return self.next_time if self.waiting else None

    def pop(self) -> Arrival:
        """Return the message that waits longest."""
        arrival = self.waiting.popleft()
        self.size -= len(arrival.raw._buff)
        return arrival


class Outbox:
    """All that waits for one client.

    Args:
        wake: called, from any thread, when something new waits.
    """

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._lock = threading.Lock()
        self._told: deque[Frame] = deque()
        self._told_size = 0
        self._flows: list[Flow] = []

    def tell(self, frame: Frame) -> None:
        """Add an answer. These are never dropped; `is_full` says when to ask for no more."""
        with self._lock:
            self._told.append(frame)
            self._told_size += len(frame)
        self._wake()

    def is_full(self) -> bool:
        """Return whether the client should first read what it has been told."""
        return self._told_size > MOST_TOLD

    def is_overfull(self) -> bool:
        """Return whether others should ask the client for nothing either."""
        return self._told_size > MOST_OF_ALL

    def add(self, flow: Flow) -> None:
        """Add a topic."""
        with self._lock:
            self._flows.append(flow)

    def remove(self, flow: Flow) -> None:
        """Remove a topic, and what waits of it."""
        with self._lock:
            self._flows = [each for each in self._flows if each is not flow]

    def put(self, flow: Flow, arrival: Arrival) -> None:
        """Add a message; the oldest ones make room for it."""
        with self._lock:
            if arrival is flow.last:
                return  # while the client subscribes once more, it comes twice
            flow.last = arrival
            flow.waiting.append(arrival)
            flow.size += len(arrival.raw._buff)
            while len(flow.waiting) > 1 and (
                len(flow.waiting) > flow.most or flow.size > MOST_BYTES or self._size() > MOST_OF_ALL
            ):
                flow.pop()
        self._wake()

    def _size(self) -> int:
        return sum(each.size for each in self._flows)

    def take(self, now: float) -> tuple[list[Frame], list[tuple[Flow, Arrival]], float | None]:
        """Take what is due.

        Args:
            now: seconds of a clock that does not jump.

        Returns:
            Answers; messages, in the order in which they came; and when to call again, None: when it wakes.
        """
        with self._lock:
            told, self._told, self._told_size = list(self._told), deque(), 0
            due = [flow for flow in self._flows if (time := flow.due()) is not None and time <= now]
            found: list[tuple[Flow, Arrival]] = []
            size = 0
            while due and size < _AT_ONCE:
                for flow in due:
                    arrival = flow.pop()
                    size += len(arrival.raw._buff)
                    found.append((flow, arrival))
                    flow.next_time = now + flow.throttle
                    if size >= _AT_ONCE:
                        break
                due = [flow for flow in due if flow.waiting and not flow.throttle]
            if found:  # who came last is the first next time
                self._flows.sort(key=lambda flow: flow.next_time)
            again = min((time for flow in self._flows if (time := flow.due()) is not None), default=None)
        found.sort(key=lambda each: each[1].at)
        return told, found, again
