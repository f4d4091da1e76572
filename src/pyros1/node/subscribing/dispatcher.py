"""The dispatcher of a subscription: decodes each message for the topic's subscribers, and calls them.

It also keeps the latched message of each publisher, for later subscribers (T18). In a node that spins, the
delivery loop gives messages to `SpinQueues` instead, where they wait for the dispatcher until the program spins.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sized
from typing import TYPE_CHECKING, Any, Protocol

from pyros1.ground.errors import LengthError, MessageError
from pyros1.msgs.large_arrays import find_layout
from pyros1.node.log.levels import ERROR, WARN
from pyros1.node.subscribing.queues import UNBOUNDED_LIMIT, Inbox
from pyros1.node.subscribing.tcp_source import MIN_LARGE_FRAME, TcpSource

if TYPE_CHECKING:
    from pyros1.node.callback_queue import CallbackQueue
    from pyros1.node.context import Context
    from pyros1.node.subscribing.queues import Item, Source
    from pyros1.node.subscribing.subscriber import Subscriber


class Stream(Protocol):
    """A subscriber's own queue, such as that of an asyncio iteration."""

    @property
    def full(self) -> bool:
        """Whether the queue is full: publishers must then be held back."""

    @property
    def wants_newest(self) -> bool:
        """Whether messages must be received even while their consumer is busy, so that the newest ones are kept."""

    @property
    def urgent(self) -> bool:
        """Whether the consumer is waiting for a message: other streams must then not hold publishers back."""

    def put(self, source: Source, item: Item) -> None:
        """Add a message to the queue. Called by one thread at a time."""


class Dispatcher:
    """Passes the messages of one topic to its subscribers.

    Args:
        context: the node's context.
        topic: the topic's full name.

    Attributes:
        subscribers: all subscribers that are not in ``direct_subscribers``. In a node that spins, they wait for `spin`.
        direct_subscribers: in a node that spins, subscribers that do not wait for `spin`; in other nodes, none.
        streams: the queues of subscribers that have their own queue.
    """

    def __init__(self, context: Context, topic: str) -> None:
        self.subscribers: tuple[Subscriber[Any], ...] = ()
        self.direct_subscribers: tuple[Subscriber[Any], ...] = ()
        self.streams: tuple[Stream, ...] = ()
        self._context = context
        self._topic = topic
        # The active subscribers, direct or not: they have received the latched messages, and now receive all others.
        self._active: tuple[Subscriber[Any], ...] = ()
        self._active_direct: tuple[Subscriber[Any], ...] = ()
        self._latched: dict[Source, Item] = {}  # latched messages that were delivered
        self._latched_on_arrival: dict[Source, Item] = {}  # latched messages that may still wait for `spin`
        self._lock = threading.RLock()  # reentrant: a signal handler in one of these methods may shut down the node

    @property
    def is_held_back(self) -> bool:
        """Whether publishers must be held back: a stream is full, and none is urgent."""
        streams = self.streams
        return bool(streams) and any(stream.full for stream in streams) and not any(stream.urgent for stream in streams)

    # Subscribers ------------------------------------------------------------------------------------------------------

    def add(self, subscriber: Subscriber[Any]) -> None:
        """Add a subscriber; it receives nothing before `activate`."""
        with self._lock:
            if subscriber.direct and self._context.callback_queue is not None:
                self.direct_subscribers = (*self.direct_subscribers, subscriber)
            else:
                self.subscribers = (*self.subscribers, subscriber)

    def remove(self, subscriber: Subscriber[Any]) -> None:
        """Remove a subscriber."""
        with self._lock:
            self.subscribers = tuple(other for other in self.subscribers if other is not subscriber)
            self.direct_subscribers = tuple(other for other in self.direct_subscribers if other is not subscriber)
            self._active = tuple(other for other in self._active if other is not subscriber)
            self._active_direct = tuple(other for other in self._active_direct if other is not subscriber)
            self.streams = tuple(other for other in self.streams if other is not subscriber.stream)

    def activate(self, subscriber: Subscriber[Any]) -> None:
        """Deliver the latched messages to a subscriber, and from now on all messages. Called by the delivery loop's
        owner.
        """
        with self._lock:
            latched = self._latched
            if subscriber in self.direct_subscribers:
                self._active_direct = (*self._active_direct, subscriber)
                latched = self._latched_on_arrival
            elif subscriber in self.subscribers and subscriber.stream is not None:
                self.streams = (*self.streams, subscriber.stream)
            elif subscriber in self.subscribers:
                self._active = (*self._active, subscriber)
            messages = list(latched.items())
        for source, item in messages:
            self._replay(subscriber, source, item)

    def _replay(self, subscriber: Subscriber[Any], source: Source, item: Item) -> None:
        """Deliver a latched message to a new subscriber."""
        if subscriber.stream is not None:
            subscriber.stream.put(source, item)
            return
        try:
            message = subscriber.decode_item(item)
        except MessageError:
            return  # this was logged when the message arrived
        message._connection_header = source.header
        if self._context.callback_queue is not None and not subscriber.direct:
            self._context.callback_queue.push(lambda: subscriber.call(message))
        else:
            subscriber.call(message)

    def forget(self, source: Source) -> None:
        """Forget the latched message of a source that has ended. Called by the delivery loop's owner."""
        with self._lock:
            self._latched.pop(source, None)
            self._latched_on_arrival.pop(source, None)

    # Messages, in the delivery loop or the thread that spins ----------------------------------------------------------

    def deliver_direct(self, source: Source, item: Item) -> bool:
        """In a node that spins, call the subscribers that do not wait for `spin`; return whether others do wait."""
        if source.header.get("latching") == "1":
            self._latched_on_arrival[source] = item
        if self._active_direct:
            self._call(self._active_direct, source, item)
        return bool(self.subscribers)

    def deliver_frame(self, source: Source, data: bytes, start: int, end: int) -> None:
        """Deliver a message that is encoded in part of a buffer."""
        active = self._active
        if source.header.get("latching") == "1":
            active = self._keep_latched(source, data[start:end])
        for stream in self.streams:
            stream.put(source, data[start:end])
        self._call(active, source, data, start, end)

    def deliver_item(self, source: Source, item: Item) -> None:
        """Deliver a message."""
        active, header = self._active, source.header
        if header.get("latching") == "1":
            active = self._keep_latched(source, item)
        for stream in self.streams:
            stream.put(source, item)
        if len(active) == 1 and item.__class__ is active[0].native_class:  # the usual case within a process
            message: Any = item
            message._connection_header = header
            active[0].call(message)
            return
        self._call(active, source, item)

    def _keep_latched(self, source: Source, item: Item) -> tuple[Subscriber[Any], ...]:
        """Keep a latched message for later subscribers; return the subscribers that receive it now."""
        with self._lock:
            if source.connected:  # if not, the message was still waiting when its publisher left
                self._latched[source] = item
            return self._active

    def _call(
        self, subscribers: tuple[Subscriber[Any], ...], source: Source, data: Any, start: int = 0, end: int = -1
    ) -> None:
        """Decode a message for the subscribers and run their callbacks; log a message that cannot be decoded.

        Args:
            subscribers: the subscribers to call.
            source: the source of the message.
            data: a buffer with a frame's body; or an item, if ``end`` is -1.
            start, end: bounds of the body in the buffer.
        """
        header = source.header
        message = decoded_by = None
        for subscriber in subscribers:
            if subscriber.decode is not decoded_by or message is None:
                try:
                    message = (
                        subscriber.decode(data, start, end, True) if end >= 0 else subscriber.decode_item(data, True)
                    )
                except LengthError as error:
                    self._warn_wrong_length(source, error)
                    message = subscriber.decode(data, start, end) if end >= 0 else subscriber.decode_item(data)
                except MessageError as error:
                    self._log_undecodable(source, error)
                    continue
                message._connection_header = header
                decoded_by = subscriber.decode
                if end - start >= MIN_LARGE_FRAME:
                    _expect_array(source, message, end - start)
                elif end < 0 and isinstance(data, bytes) and len(data) >= MIN_LARGE_FRAME:
                    _expect_array(source, message, len(data))
            subscriber.call(message)

    def decode_for_stream(self, subscriber: Subscriber[Any], source: Source, item: Item) -> Any:
        """Decode an item that a stream has received; log it and return None if it cannot be decoded."""
        try:
            message = subscriber.decode_item(item, exact=True)
        except LengthError as error:
            self._warn_wrong_length(source, error)
            message = subscriber.decode_item(item)
        except MessageError as error:
            self._log_undecodable(source, error)
            return None
        message._connection_header = source.header
        if isinstance(item, bytes) and len(item) >= MIN_LARGE_FRAME:
            _expect_array(source, message, len(item))
        return message

    def _log_undecodable(self, source: Source, error: MessageError) -> None:
        publisher_name = source.header.get("callerid", "?")
        self._context.log.peer_event(ERROR, "%s from %s: %s (message dropped)", self._topic, publisher_name, error)

    def _warn_wrong_length(self, source: Source, error: LengthError) -> None:
        """Warn that a message is longer or shorter than its type requires; it is still delivered, as in stock nodes."""
        publisher_name = source.header.get("callerid", "?")
        text = "%s from %s: received %s: does the publisher have another definition, or append a checksum?"
        self._context.log.peer_event(
            WARN, text, self._topic, publisher_name, error, max_texts=1, link=(self._topic, publisher_name)
        )


def _expect_array(source: Source, message: Any, size: int) -> None:
    """Tell a TCP link where the array of a large message is, so that it can receive the next one without copying."""
    array_layout = find_layout(type(message))
    if array_layout is not None and isinstance(source, TcpSource):
        array = getattr(message, array_layout.field, None)
        if isinstance(array, Sized) and len(array) >= MIN_LARGE_FRAME:  # a program's own class may hold anything there
            source.set_expected_layout(size, len(array), array_layout.tail_size, array_layout.has_length_field)


class SpinQueue:
    """The messages of one source that wait for `spin`; the callback queue has a call of `deliver_next` for each.

    Args:
        source: the source of the messages.
        dispatcher: runs the callbacks.
    """

    def __init__(self, source: Source, dispatcher: Dispatcher) -> None:
        self._inbox = Inbox(source)
        self._dispatcher = dispatcher
        self._calls: deque[None] = deque()  # one for each call of `deliver_next` that has not begun
        self._in_progress: deque[None] = deque()  # one for each call that is taking its message

    def __len__(self) -> int:
        return len(self._inbox)

    @property
    def dropped(self) -> int:
        """Number of messages lost so far; may be off by one while a message is being taken."""
        return self._inbox.dropped

    @property
    def is_drained(self) -> bool:
        """Whether all messages have been taken, so that `dropped` is exact."""
        return not (self._calls or self._in_progress)

    def put(self, item: Item, limit: int) -> bool:
        """Add a message. Called by one thread at a time.

        Returns:
            Whether one more call of `deliver_next` must be queued.
        """
        self._inbox.put(item, limit)
        # There must never be more messages than calls. Messages from before the limit was lowered also count.
        if len(self._calls) >= limit and len(self._calls) >= len(self._inbox):
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
            self._dispatcher.deliver_item(self._inbox.source, item)


class SpinQueues:
    """In a node that spins, receives the messages in place of the dispatcher; they wait here for `spin`.

    Args:
        dispatcher: runs the callbacks.
        callback_queue: the node's callback queue.

    Attributes:
        limit: maximum number of waiting messages of each source; None for UNBOUNDED_LIMIT. Beyond that, the oldest
            are dropped.
    """

    def __init__(self, dispatcher: Dispatcher, callback_queue: CallbackQueue) -> None:
        self.limit: int | None = None
        self._dispatcher = dispatcher
        self._callback_queue = callback_queue
        self._queues: dict[Source, SpinQueue] = {}
        self._ended_queues: list[SpinQueue] = []  # queues of removed sources, with messages that still wait
        self._dropped = 0  # number of messages lost in removed queues

    @property
    def waiting(self) -> int:
        """Number of waiting messages."""
        return sum(map(len, [*self._queues.values(), *self._ended_queues]))

    @property
    def dropped(self) -> int:
        """Number of messages lost so far."""
        return self._dropped + sum(queue.dropped for queue in [*self._queues.values(), *self._ended_queues])

    def deliver_frame(self, source: Source, data: bytes, start: int, end: int) -> None:
        """Queue a message that is encoded in part of a buffer. Called by one thread at a time."""
        self.deliver_item(source, data[start:end])

    def deliver_item(self, source: Source, item: Item) -> None:
        """Queue a message. Called by one thread at a time."""
        if not self._dispatcher.deliver_direct(source, item):
            return
        queue = self._queues.get(source)
        if queue is None:
            queue = self._queues[source] = SpinQueue(source, self._dispatcher)
        if queue.put(item, self.limit or UNBOUNDED_LIMIT):
            self._callback_queue.push(queue.deliver_next)

    def forget(self, source: Source) -> None:
        """Remove a source that has ended. Its waiting messages are still delivered by the queued calls."""
        queue = self._queues.pop(source, None)
        if queue is not None:
            self._ended_queues.append(queue)
        for queue in [other for other in self._ended_queues if other.is_drained]:
            self._ended_queues.remove(queue)
            self._dropped += queue.dropped
