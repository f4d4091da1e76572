"""Messages on their way from the one who hands them over to the one who delivers them, who may do so at the same time
and without a lock.

What is too much is dropped by the deque itself, within its `append`: so the newest can never be dropped for one that
was taken meanwhile.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from pyros1.net.bell import Bell

S = TypeVar("S")
T = TypeVar("T")


class _Queue(deque[T]):
    """A deque that is equal to itself only: `remove` finds that one, and not another that is empty as well."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]  # deques have none, since they are equal by what is in them


class Inbox(Generic[S, T]):
    """The messages of one source.

    Args:
        source: where they come from.

    Attributes:
        lost: messages that were lost on their way to here, as far as the source knows; for the source to count.
        in_line: whether the one who takes has it on his list.
    """

    __slots__ = ("_limit", "_newest", "_put", "_queues", "_taken", "in_line", "lost", "source")

    def __init__(self, source: S) -> None:
        self.source = source
        self.lost = 0
        self.in_line = False
        self._limit: int | None = None
        self._newest: _Queue[T] = _Queue()
        self._queues: deque[_Queue[T]] = deque([self._newest])  # with another limit begins another queue
        self._put = self._taken = 0

    def __len__(self) -> int:
        return sum(map(len, list(self._queues)))

    @property
    def dropped(self) -> int:
        """Messages lost so far, here or before; off by one for a moment while others put and take."""
        return self.lost + max(0, self._put - self._taken - len(self))

    def full(self, limit: int) -> bool:
        """Return whether the next message will cost an older one."""
        return len(self._newest) >= limit

    def put(self, item: T, limit: int | None) -> None:
        """Add a message. One thread at a time.

        Args:
            limit: most messages that wait, the oldest are dropped; 0 or None for no limit.
        """
        if limit != self._limit:
            self._limit = limit
            newest: _Queue[T] = _Queue(maxlen=limit or None)
            self._queues.append(newest)  # from now on nothing is put into those before
            self._newest = newest
        self._put += 1
        self._newest.append(item)

    def take(self) -> T | None:
        """Take the oldest message, None if there is none."""
        while True:
            queue = self._queues[0]
            last = queue is self._newest  # asked first: only one that is not the last is, once empty, empty for ever
            try:
                item = queue.popleft()
            except IndexError:
                if last:
                    return None
                with contextlib.suppress(ValueError):  # if another thread takes, too
                    self._queues.remove(queue)
                continue
            self._taken += 1
            return item


class Handover(Generic[S, T]):
    """All inboxes of one taker.

    Attributes:
        line: those with messages, in the order of their turns.
        inboxes: all.
    """

    def __init__(self) -> None:
        self.line: deque[Inbox[S, T]] = deque()
        self.inboxes: dict[Inbox[S, T], None] = {}
        self._dropped = 0  # by inboxes that are forgotten
        self._room = Bell()

    def __len__(self) -> int:
        return sum(map(len, list(self.inboxes)))

    @property
    def dropped(self) -> int:
        """Messages lost so far, in all inboxes."""
        return self._dropped + sum(inbox.dropped for inbox in list(self.inboxes))

    def open(self, inbox: Inbox[S, T]) -> None:
        """Take messages out of an inbox from now on, until it is forgotten."""
        self.inboxes[inbox] = None

    def line_up(self, inbox: Inbox[S, T]) -> None:
        """Put an inbox with messages into the line, if it is not there."""
        if not inbox.in_line:
            inbox.in_line = True
            self.line.append(inbox)

    def leave_line(self, inbox: Inbox[S, T]) -> bool:
        """Note that an inbox was taken out of the line and emptied. By who takes.

        What was put into it just now, by somebody who still believed it to be in the line, brings it back.

        Returns:
            Whether it is empty.
        """
        inbox.in_line = False
        self._room.ring()
        if len(inbox):
            self.line_up(inbox)
            return False
        return True

    def forget(self, inbox: Inbox[S, T]) -> None:
        """Take no more from an inbox. By who takes."""
        if inbox in self.inboxes:
            self._dropped += inbox.dropped
            del self.inboxes[inbox]

    def wait_for_room(self, inbox: Inbox[S, T], most: int, ended: Callable[[], bool]) -> None:
        """Wait until fewer than ``most`` messages are in an inbox, or something has ended."""
        while len(inbox) >= most and not ended():
            self._room.wait(lambda: len(inbox) < most or ended(), 0.1)

    def ring(self) -> None:
        """Let those look again who wait for room."""
        self._room.ring()
