"""Inboxes: queues between the thread that puts messages and the thread that delivers them, which may work at the same
time, without a lock.

Messages beyond the limit are dropped by the deque itself, within its `append`, so the newest message can never be
dropped for one that was taken meanwhile.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from pyros1.net.signal_safe import Condition

S = TypeVar("S")
T = TypeVar("T")


class _Queue(deque[T]):
    """A deque that is equal only to itself, so that `remove` does not find another empty one."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]  # deques have none, since they compare by content


class Inbox(Generic[S, T]):
    """Queue of the messages of one source.

    Args:
        source: the source of the messages.

    Attributes:
        lost: number of messages that were lost on the way here; the source counts them.
        is_ready: whether it is in the line of inboxes with messages.
    """

    __slots__ = ("_limit", "_newest", "_put", "_queues", "_taken", "is_ready", "lost", "source")

    def __init__(self, source: S) -> None:
        self.source = source
        self.lost = 0
        self.is_ready = False
        self._limit: int | None = None
        self._newest: _Queue[T] = _Queue()
        self._queues: deque[_Queue[T]] = deque([self._newest])  # a new limit begins a new queue
        self._put = self._taken = 0

    def __len__(self) -> int:
        return sum(map(len, list(self._queues)))

    @property
    def dropped(self) -> int:
        """Number of messages lost so far, here or before; may briefly be one too low, but never too high."""
        return self.lost + max(0, self._put - len(self) - self._taken)  # in this order: other threads add and take

    def full(self, limit: int) -> bool:
        """Return whether the next message will replace an older one."""
        return len(self._newest) >= limit

    def put(self, item: T, limit: int | None) -> None:
        """Add a message. One thread at a time.

        Args:
            limit: maximum number of waiting messages, beyond which the oldest are dropped; 0 or None for no limit.
        """
        if limit != self._limit:
            self._limit = limit
            newest: _Queue[T] = _Queue(maxlen=limit or None)
            self._queues.append(newest)  # from now on nothing is put into the earlier queues
            self._newest = newest
        self._newest.append(item)
        self._put += 1

    def take(self) -> T | None:
        """Take the oldest message, None if there is none."""
        while True:
            queue = self._queues[0]
            last = (
                queue is self._newest
            )  # checked first: only queues before the last one stay empty once they are empty
            self._taken += 1  # first: a message that is being taken does not count as lost
            try:
                return queue.popleft()
            except IndexError:
                self._taken -= 1
                if last:
                    return None
                with contextlib.suppress(ValueError):  # if another thread takes messages as well
                    self._queues.remove(queue)


class InboxSet(Generic[S, T]):
    """All inboxes of one delivery.

    Attributes:
        ready: inboxes with messages, in the order of their turns.
        inboxes: all inboxes.
    """

    def __init__(self) -> None:
        self.ready: list[Inbox[S, T]] = []  # short as a rule; see `taking`
        self.inboxes: dict[Inbox[S, T], None] = {}
        self._dropped = 0  # in removed inboxes
        self._room = Condition()

    def __len__(self) -> int:
        return sum(map(len, list(self.inboxes)))

    @property
    def dropped(self) -> int:
        """Number of messages lost so far, in all inboxes."""
        return self._dropped + sum(inbox.dropped for inbox in list(self.inboxes))

    def open(self, inbox: Inbox[S, T]) -> None:
        """Start taking messages out of an inbox, until it is removed."""
        self.inboxes[inbox] = None

    def mark_ready(self, inbox: Inbox[S, T]) -> None:
        """Put an inbox with messages into the line, if it is not there."""
        if not inbox.is_ready:
            inbox.is_ready = True
            self.ready.append(inbox)

    def mark_empty(self, inbox: Inbox[S, T]) -> bool:
        """Note that an inbox was taken out of the line and emptied. Called by the thread that takes messages.

        If a thread has just put a message into it without noticing this, the inbox goes back into the line.

        Returns:
            Whether it is empty.
        """
        inbox.is_ready = False
        self._room.notify_all()
        if len(inbox):
            self.mark_ready(inbox)
            return False
        return True

    def forget(self, inbox: Inbox[S, T]) -> None:
        """Stop taking messages from an inbox. Called by the thread that takes them."""
        if inbox in self.inboxes:
            del self.inboxes[inbox]  # first: its lost messages must not count twice
            self._dropped += inbox.dropped

    def wait_for_room(self, inbox: Inbox[S, T], maximum: int, ended: Callable[[], bool]) -> None:
        """Wait until fewer than ``maximum`` messages are in an inbox, or something has ended."""
        while len(inbox) >= maximum and not ended():
            self._room.wait_for(lambda: len(inbox) < maximum or ended(), 0.1)

    def notify_all(self) -> None:
        """Wake the threads that wait for room."""
        self._room.notify_all()
