"""Queues messages for a viewer, in bounded memory; each channel's oldest messages are dropped first."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from operator import attrgetter
from typing import NamedTuple

from pyros1.web.server.turns import Turns

MAX_CHANNEL_BYTES = 1 << 20
"""Maximum number of bytes queued per subscription in addition to its newest message. This limits a viewer's lag."""
MAX_BYTES = 64 << 20
"""Maximum total number of bytes queued for a viewer."""
_MESSAGE_OVERHEAD = 256
"""Memory overhead of a queued message in bytes."""


class QueuedMessage(NamedTuple):
    """A message in the queue of a subscription.

    Attributes:
        ticket: the ticket of the subscription; see `Outbox.open`.
        time: time of reception in nanoseconds.
        payload: the serialized message.
        latched_by: name of the publisher if the message is latched, else None. Each publisher's newest latched message
            is kept, since it may never be published again.
        arrived_at: time of reception in seconds, by a monotonic clock.
    """

    ticket: int
    time: int
    payload: bytes
    latched_by: str | None
    arrived_at: float = 0.0

    @property
    def size(self) -> int:
        """The message's size in memory, in bytes."""
        return len(self.payload) + _MESSAGE_OVERHEAD


class _Queue:
    """The queued messages of one subscription."""

    def __init__(self) -> None:
        self._messages: deque[QueuedMessage] = deque()
        self._latched: dict[str, QueuedMessage] = {}  # by publisher; older than all messages in _messages
        self._newest_latched: dict[str, QueuedMessage] = {}  # by publisher
        self.size = 0

    def __len__(self) -> int:
        return len(self._messages) + len(self._latched)

    def put(self, message: QueuedMessage) -> int:
        """Add a message; return its size in memory."""
        latched_by = message.latched_by
        if latched_by is not None:
            old = self._latched.pop(latched_by, None)
            if old is not None:
                self.size -= old.size
            self._newest_latched[latched_by] = message
        self._messages.append(message)
        size = message.size
        self.size += size
        return size

    def take(self) -> QueuedMessage:
        """Remove the oldest message and return it."""
        message = self._latched.pop(next(iter(self._latched))) if self._latched else self._messages.popleft()
        if message.latched_by is not None and self._newest_latched[message.latched_by] is message:
            del self._newest_latched[message.latched_by]
        self.size -= message.size
        return message

    def drop(self) -> bool:
        """Drop the oldest message that need not be kept; return False if there is none.

        The newest message is kept, and so is the newest latched message of each publisher.
        """
        while len(self._messages) > 1:
            message = self._messages.popleft()
            if message.latched_by is not None and self._newest_latched[message.latched_by] is message:
                self._latched[message.latched_by] = message
                continue
            self.size -= message.size
            return True
        return False


class Outbox:
    """All messages queued for a viewer. Thread-safe.

    Args:
        max_bytes, max_channel_bytes: limits, see `MAX_BYTES` and `MAX_CHANNEL_BYTES`.
        wake: called, from any thread, when `take` has something to return.

    Attributes:
        dropped: number of messages that were dropped for lack of space.
    """

    def __init__(
        self,
        max_bytes: int = MAX_BYTES,
        max_channel_bytes: int = MAX_CHANNEL_BYTES,
        wake: Callable[[], object] = lambda: None,
    ) -> None:
        self._max_bytes = max_bytes
        self._max_channel_bytes = max_channel_bytes
        self._wake = wake
        self._lock = threading.Condition()  # notified when a thread has sent a message
        self._queues: dict[int, _Queue] = {}
        self._ready: deque[int] = deque()  # the ticket of each subscription with queued messages
        self._last_ticket = 0
        self._size = 0
        self._turns = Turns()
        self._sent_ticket = 0  # the ticket of the message that a thread is sending; 0 for none
        self.dropped = 0

    @property
    def size(self) -> int:
        """Total size of the queued messages in bytes."""
        return self._size

    def open(self) -> int:
        """Add a subscription, and return its ticket, which is never reused."""
        with self._lock:
            self._last_ticket += 1
            self._queues[self._last_ticket] = _Queue()
            return self._last_ticket

    def close(self, ticket: int) -> None:
        """Remove a subscription, and drop its queued messages. Messages that are put later are ignored.

        If a thread is sending one of the subscription's messages, wait for it, since none may be sent after this call.
        """
        with self._lock:
            queue = self._queues.pop(ticket, None)
            if queue:
                self._size -= queue.size
                self._ready.remove(ticket)
            while self._sent_ticket == ticket:
                self._lock.wait()

    @property
    def is_free(self) -> bool:
        """Whether a message might be sent immediately: nothing is queued, and nothing is being sent."""
        return self._turns.is_free

    def put(self, message: QueuedMessage, may_send: bool = False) -> bool:
        """Add a message; older messages are dropped if there is no space.

        Args:
            message: the message.
            may_send: whether the caller may send the message instead.

        Returns:
            Whether the caller must now send the message, which has not been queued, and then call `end_sending`.
        """
        with self._lock:
            queue = self._queues.get(message.ticket)
            if queue is None:
                return False
            if may_send and self._turns.begin():
                self._sent_ticket = message.ticket
                return True
            self._add(queue, message)
            must_wake = self._turns.leave_to_loop()
        if must_wake:
            self._wake()
        return False

    def end_sending(self, unsent: QueuedMessage | None) -> None:
        """End the sending that `put` requested. If the message was not sent, ``unsent`` is that message, which is then
        queued. It stays in order, since each topic's messages arrive one after the other.
        """
        with self._lock:
            queue = None if unsent is None else self._queues.get(unsent.ticket)
            if unsent is not None and queue is not None:
                self._add(queue, unsent)
                self._turns.leave_to_loop()
            self._sent_ticket = 0
            self._lock.notify_all()
            must_wake = self._turns.end()
        if must_wake:
            self._wake()

    def release(self) -> None:
        """Let messages be sent immediately from now on if nothing is queued. Called when everything taken has been
        sent.
        """
        with self._lock:
            if not self._ready:
                self._turns.release()

    def _add(self, queue: _Queue, message: QueuedMessage) -> None:
        if not queue.size:
            self._ready.append(message.ticket)
        previous_size = queue.size
        size = queue.put(message)
        while queue.size - size > self._max_channel_bytes and queue.drop():
            self.dropped += 1
        self._size += queue.size - previous_size
        while self._size > self._max_bytes and self._make_room(message.ticket):
            self.dropped += 1

    def take(self, byte_limit: int) -> list[QueuedMessage]:
        """Remove the oldest messages of each subscription in turn, and return them in order of arrival.

        Args:
            byte_limit: size in bytes after which no more messages are removed; at least one message is returned if any
                is queued.
        """
        messages: list[QueuedMessage] = []
        with self._lock:
            if self._turns.is_threads:
                return messages
            while self._ready and byte_limit > 0:
                queue = self._queues[self._ready[0]]
                message = queue.take()
                self._size -= message.size
                byte_limit -= message.size
                messages.append(message)
                if queue:
                    self._ready.rotate(-1)
                else:
                    self._ready.popleft()
        messages.sort(key=_arrival_time)
        return messages

    def _make_room(self, newest_ticket: int) -> bool:
        """Drop a message of the subscription with the most queued bytes; return whether a message could be dropped."""
        largest_first = sorted(self._ready, key=lambda each: self._queues[each].size, reverse=True)
        for ticket in largest_first:
            queue = self._queues[ticket]
            previous_size = queue.size
            if queue.drop():
                self._size -= previous_size - queue.size
                return True
        for ticket in largest_first:  # only messages that should be kept are left, but even these need too much space
            queue = self._queues[ticket]
            if ticket != newest_ticket or len(queue) > 1:
                self._size -= queue.take().size
                if not queue:
                    self._ready.remove(ticket)
                return True
        return False


_arrival_time = attrgetter("arrived_at")
