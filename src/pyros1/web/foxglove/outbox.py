"""Messages that wait for a viewer: bounded in bytes, the oldest of a channel are dropped first."""

from __future__ import annotations

import threading
from collections import deque
from operator import attrgetter
from typing import NamedTuple

CHANNEL_ROOM = 1 << 20
"""Bytes of a subscription that may wait besides its newest message. A slow viewer is at most so far behind."""
ROOM = 64 << 20
"""Bytes that may wait for a viewer in all."""
_OVERHEAD = 256
"""Bytes that a waiting message takes besides its own."""


class Waiting(NamedTuple):
    """A message that waits.

    Attributes:
        ticket: of its subscription; see `Outbox.open`.
        time: when it came, in nanoseconds.
        payload: its bytes.
        keeper: name of its publisher if it is latched: the newest of each is kept, as it may never come again.
        at: when it came, in seconds of a clock that does not jump.
    """

    ticket: int
    time: int
    payload: bytes
    keeper: str | None
    at: float = 0.0

    @property
    def size(self) -> int:
        """Bytes that it takes."""
        return len(self.payload) + _OVERHEAD


class _Queue:
    """What waits on one subscription."""

    def __init__(self) -> None:
        self._messages: deque[Waiting] = deque()
        self._kept: dict[str, Waiting] = {}  # by keeper; older than all others
        self._newest: dict[str, Waiting] = {}  # by keeper
        self.size = 0

    def __len__(self) -> int:
        return len(self._messages) + len(self._kept)

    def put(self, message: Waiting) -> int:
        """Add a message; return the bytes that it takes."""
        keeper = message.keeper
        if keeper is not None:
            old = self._kept.pop(keeper, None)
            if old is not None:
                self.size -= old.size
            self._newest[keeper] = message
        self._messages.append(message)
        size = message.size
        self.size += size
        return size

    def take(self) -> Waiting:
        """Remove the oldest message and return it."""
        message = self._kept.pop(next(iter(self._kept))) if self._kept else self._messages.popleft()
        if message.keeper is not None and self._newest[message.keeper] is message:
            del self._newest[message.keeper]
        self.size -= message.size
        return message

    def drop(self) -> bool:
        """Drop the oldest message that is neither the newest nor to be kept; return whether there was one."""
        while len(self._messages) > 1:
            message = self._messages.popleft()
            if message.keeper is not None and self._newest[message.keeper] is message:
                self._kept[message.keeper] = message
                continue
            self.size -= message.size
            return True
        return False


class Outbox:
    """The messages that wait for a viewer. Any thread may put.

    Attributes:
        dropped: number of messages that were dropped for lack of room.
    """

    def __init__(self, room: int = ROOM, channel_room: int = CHANNEL_ROOM) -> None:
        self._room = room
        self._channel_room = channel_room
        self._lock = threading.Lock()
        self._queues: dict[int, _Queue] = {}
        self._turns: deque[int] = deque()  # each subscription with messages, once
        self._last = 0
        self._size = 0
        self.dropped = 0

    @property
    def size(self) -> int:
        """Bytes that wait."""
        return self._size

    def open(self) -> int:
        """Take messages of another subscription from now on; return its ticket, which is never used again."""
        with self._lock:
            self._last += 1
            self._queues[self._last] = _Queue()
            return self._last

    def close(self, ticket: int) -> None:
        """Take none of a subscription any more, and forget those that wait."""
        with self._lock:
            queue = self._queues.pop(ticket, None)
            if queue:
                self._size -= queue.size
                self._turns.remove(ticket)

    def put(self, message: Waiting) -> None:
        """Add a message; old ones are dropped if there is no room."""
        with self._lock:
            queue = self._queues.get(message.ticket)
            if queue is None:
                return
            if not queue.size:
                self._turns.append(message.ticket)
            before = queue.size
            size = queue.put(message)
            while queue.size - size > self._channel_room and queue.drop():
                self.dropped += 1
            self._size += queue.size - before
            while self._size > self._room and self._make_room(message.ticket):
                self.dropped += 1

    def take(self, most: int) -> list[Waiting]:
        """Remove and return messages, of all subscriptions in turns, in the order in which they came.

        Args:
            most: bytes; at least one message is returned if one waits.
        """
        taken: list[Waiting] = []
        with self._lock:
            while self._turns and most > 0:
                queue = self._queues[self._turns[0]]
                message = queue.take()
                self._size -= message.size
                most -= message.size
                taken.append(message)
                if queue:
                    self._turns.rotate(-1)
                else:
                    self._turns.popleft()
        taken.sort(key=_at)
        return taken

    def _make_room(self, newest: int) -> bool:
        """Drop a message of the subscription that takes most; return whether one could be dropped."""
        fattest_first = sorted(self._turns, key=lambda each: self._queues[each].size, reverse=True)
        for ticket in fattest_first:
            queue = self._queues[ticket]
            before = queue.size
            if queue.drop():
                self._size -= before - queue.size
                return True
        for ticket in fattest_first:  # each has only what should be kept: too much, all the same
            queue = self._queues[ticket]
            if ticket != newest or len(queue) > 1:
                self._size -= queue.take().size
                if not queue:
                    self._turns.remove(ticket)
                return True
        return False


_at = attrgetter("at")
