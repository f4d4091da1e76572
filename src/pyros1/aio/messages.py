"""The messages of one topic, for ``async for``."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING, Generic, TypeVar

from pyros1.node.subscribing.queues import Inbox, InboxSet

if TYPE_CHECKING:
    from types import TracebackType

    from pyros1.node.subscribing.queues import Item, Source
    from pyros1.node.subscribing.subscriber import Subscriber

_M = TypeVar("_M")

MAX_PENDING = 100
"""Number of queued messages at which a publisher is held back, for iterations without ``queue_size``."""


class Messages(Generic[_M]):
    """The messages of one topic, for ``async for``; created by ``Node.subscribe``. Ends when the node shuts down.

    The messages are queued undecoded, in one queue for each publisher; the publishers take turns, as for a callback.

    No lock is used: messages may be added and removed by different threads, and a signal handler may run at any time.

    Args:
        loop: the asyncio loop in which the iteration runs.
        limit: maximum number of queued messages of each publisher; older ones are dropped. With None, nothing is
            dropped, and publishers are held back instead.
        urgent: whether the message that this iteration waits for must not be held back by other subscribers.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, limit: int | None, urgent: bool = False) -> None:
        self._loop = loop
        self._thread = threading.get_ident()
        self._limit = limit
        self._urgent = urgent
        self._inbox_by_source: dict[Source, Inbox] = {}
        self._inbox_set = InboxSet()
        self._ready = asyncio.Event()
        self._is_wake_scheduled = False  # whether the asyncio loop has been asked to check for messages
        self._ended = False
        self._abandoned = False
        self._full_inboxes: set[Inbox] = set()  # the inboxes whose publishers are held back
        self._cleanup_at = 1  # number of inboxes at which empty inboxes of disconnected publishers are removed
        self._subscriber: Subscriber[_M] | None = None

    # For the subscription ---------------------------------------------------------------------------------------------

    def put(self, source: Source, item: Item) -> None:
        """Add a message of a publisher. Called by one thread at a time."""
        inbox = self._inbox_by_source.get(source)
        if inbox is None:
            inbox = self._open_inbox(source)
        inbox.put(item, self._limit)
        if not inbox.is_ready:
            self._inbox_set.mark_ready(inbox)
        if self._limit is None and inbox.is_full(MAX_PENDING):
            self._full_inboxes.add(inbox)
            if not inbox.is_full(MAX_PENDING // 2):
                self._full_inboxes.discard(inbox)  # the loop may have emptied the inbox before it was in the set
        if not self._is_wake_scheduled:
            self._is_wake_scheduled = True
            self._wake()

    def _open_inbox(self, source: Source) -> Inbox:
        """Create a queue for a publisher; remove the empty queues of disconnected publishers."""
        if len(self._inbox_by_source) >= self._cleanup_at:
            for other_source, inbox in list(self._inbox_by_source.items()):
                if not other_source.connected and not len(inbox):
                    self._inbox_set.remove(inbox)
                    del self._inbox_by_source[other_source]
            self._cleanup_at = max(1, 2 * len(self._inbox_by_source))
        inbox = self._inbox_by_source[source] = Inbox(source)
        self._inbox_set.add(inbox)
        return inbox

    @property
    def full(self) -> bool:
        """Whether publishers must be held back."""
        return bool(self._full_inboxes) and not self._ended

    @property
    def wants_newest(self) -> bool:
        """Whether newer messages replace older ones, so that they must be received even while the loop is busy."""
        return self._limit is not None and not self._urgent

    @property
    def urgent(self) -> bool:
        """Whether this iteration waits for a message that other subscribers must not hold back."""
        return self._urgent and not self._ended and not self._inbox_set.ready

    def _wake(self) -> None:
        if threading.get_ident() == self._thread:
            self._ready.set()
            return
        try:
            self._loop.call_soon_threadsafe(self._ready.set)
        except RuntimeError:  # the asyncio loop is closed, so nothing iterates any more
            self._ended = True

    def attach(self, subscriber: Subscriber[_M]) -> None:
        """Set the handle of the subscription, which may already have received messages. Thread-safe."""
        self._subscriber = subscriber
        if self._abandoned:
            subscriber.unregister()
        self._wake()

    def abandon(self) -> None:
        """End the iteration and unsubscribe, now or when the handle is set, without waiting for the master."""
        self._abandoned = True
        self.end()
        if self._subscriber is not None:
            self._loop.run_in_executor(None, self._subscriber.unregister)

    # For the program --------------------------------------------------------------------------------------------------

    @property
    def waiting(self) -> int:
        """Number of messages queued for the iteration."""
        return len(self._inbox_set)

    @property
    def dropped(self) -> int:
        """Number of messages dropped because the iteration was too slow; see ``queue_size``."""
        return self._inbox_set.dropped

    def end(self) -> None:
        """End the iteration after the messages that are already queued. Thread-safe."""
        self._ended = True
        self._wake()
        if self._subscriber is not None:
            self._subscriber.resume_publishers()

    def __aiter__(self) -> AsyncIterator[_M]:
        return self

    async def __anext__(self) -> _M:
        while True:
            while self._inbox_set.ready:
                message = self._next_message()
                if message is not None:
                    return message
            self._is_wake_scheduled = False
            self._ready.clear()
            if self._inbox_set.ready:  # added by a thread that assumed that the loop would check
                continue
            if self._ended:
                raise StopAsyncIteration
            await self._ready.wait()

    def _next_message(self) -> _M | None:
        """Return the next message of the publisher whose turn it is; None if it has none, or it cannot be decoded."""
        inbox = self._inbox_set.ready.pop(0)
        item = inbox.take()
        if len(inbox):
            self._inbox_set.ready.append(inbox)
        else:
            self._inbox_set.mark_empty(inbox)
        if inbox in self._full_inboxes and not inbox.is_full(MAX_PENDING // 2):
            self._full_inboxes.discard(inbox)
            if not self._full_inboxes and self._subscriber is not None:
                self._subscriber.resume_publishers()
        if item is None or self._subscriber is None:
            return None
        return self._subscriber.decode_for_stream(inbox.source, item)

    async def aclose(self) -> None:
        """End the iteration, unsubscribe, and wait until the subscription has ended."""
        self.end()
        if self._subscriber is not None:
            # A cancellation ends only the wait.
            await asyncio.shield(self._loop.run_in_executor(None, self._subscriber.unregister))

    async def __aenter__(self) -> Messages[_M]:
        return self

    async def __aexit__(
        self, error_class: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.aclose()
