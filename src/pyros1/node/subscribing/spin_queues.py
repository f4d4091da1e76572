"""Queues of messages that wait for `spin`: the newest of each source. Their callbacks wait in ``callback_queue.py``."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from pyros1.node.subscribing.inbox import Inbox

S = TypeVar("S")
T = TypeVar("T")


class SpinQueue(Generic[S, T]):
    """The messages of one source that wait for `spin`; one call is queued for each.

    Args:
        source: the source of the messages.
        deliver: called with (source, item).
    """

    def __init__(self, source: S, deliver: Callable[[S, T], None]) -> None:
        self._inbox: Inbox[S, T] = Inbox(source)
        self._deliver = deliver
        self._calls: deque[None] = deque()  # one for each call of `deliver_next` that has not begun
        self._in_progress: deque[None] = deque()  # one for each call that takes its message now

    def __len__(self) -> int:
        return len(self._inbox)

    @property
    def dropped(self) -> int:
        """Number of messages lost so far; may be off by one while a message is taken."""
        return self._inbox.dropped

    @property
    def is_drained(self) -> bool:
        """Whether all messages have been taken, so that `dropped` is right."""
        return not (self._calls or self._in_progress)

    def put(self, item: T, limit: int) -> bool:
        """Add a message. One thread at a time.

        Returns:
            Whether one more call of `deliver_next` must be queued.
        """
        self._inbox.put(item, limit)
        if len(self._calls) >= limit:  # there are never more messages than calls
            return False
        self._calls.append(None)
        return True

    def deliver_next(self) -> None:
        """Deliver the oldest message, in the thread that spins."""
        self._in_progress.append(None)
        self._calls.popleft()
        item = self._inbox.take()
        self._in_progress.pop()
        if item is not None:
            self._deliver(self._inbox.source, item)


class SpinQueues(Generic[S, T]):
    """The queues of all sources of one subscription.

    Args:
        deliver: called with (source, item) in the thread that spins.
    """

    def __init__(self, deliver: Callable[[S, T], None]) -> None:
        self._deliver = deliver
        self._queues: dict[S, SpinQueue[S, T]] = {}
        self._ended: list[SpinQueue[S, T]] = []  # of removed sources: their last messages wait
        self._dropped = 0  # in removed queues

    def __len__(self) -> int:
        return sum(map(len, [*self._queues.values(), *self._ended]))

    @property
    def dropped(self) -> int:
        """Number of messages lost so far."""
        return self._dropped + sum(queue.dropped for queue in [*self._queues.values(), *self._ended])

    def put(self, source: S, item: T, limit: int) -> Callable[[], None] | None:
        """Add a message. One thread at a time.

        Args:
            limit: maximum number of waiting messages of each source; the oldest are dropped.

        Returns:
            The call to queue for it; None if enough calls are queued.
        """
        queue = self._queues.get(source)
        if queue is None:
            queue = self._queues[source] = SpinQueue(source, self._deliver)
        return queue.deliver_next if queue.put(item, limit) else None

    def forget(self, source: S) -> None:
        """Remove a source that has ended. Its waiting messages are still delivered by the queued calls."""
        queue = self._queues.pop(source, None)
        if queue is not None:
            self._ended.append(queue)
        for queue in [each for each in self._ended if each.is_drained]:
            self._ended.remove(queue)
            self._dropped += queue.dropped
