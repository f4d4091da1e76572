"""Queues of messages that wait to be delivered, most of them still encoded, and the sources of these messages.

* `Batch`: the messages of one receive from a TCP link.
* `Inbox`: a queue between the thread that puts messages and the thread that delivers them, which may work at the same
  time, without a lock. Messages beyond the limit are dropped by the deque itself, within its `append`, so the newest
  message can never be dropped in place of one that was taken meanwhile.
* `Backlog`: the newest messages, while callbacks are too slow.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable, Iterable
from time import perf_counter
from typing import TYPE_CHECKING, Protocol, TypeVar

from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.large_arrays import SplitBody
from pyros1.net.signal_safe import Condition

if TYPE_CHECKING:
    from pyros1.node.subscribing.dispatcher import Dispatcher, SpinQueues
    from pyros1.node.subscribing.tcp_source import TcpSource

_T = TypeVar("_T")
UNBOUNDED_LIMIT = 1000
"""Maximum number of waiting messages if neither side set a queue size; beyond that the publisher waits, as with TCP."""
Item = bytes | SplitBody | Message | AnyMsg
"""A message that waits to be delivered: encoded, or an object from a publisher in this process."""


class Source(Protocol):
    """The receiving end of a link: over TCP, over UDP, with shared memory, or within the process.

    Attributes:
        header: the publisher's connection header.
        uri: URI of the publisher's slave API.
        transport: the link's transport.
        messages: number of messages received so far.
    """

    header: dict[str, str]
    uri: str
    transport: str
    messages: int

    @property
    def address(self) -> str:
        """The description of the link's sockets in ``getBusInfo``."""

    @property
    def connected(self) -> bool:
        """Whether the link is open."""

    def close(self) -> None:
        """Close the link."""


class _Queue(deque[_T]):
    """A deque that equals only itself, so that `remove` does not find another empty deque."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]  # deques have none, since they compare by content


class Inbox:
    """Queue of the messages of one source.

    Args:
        source: the source of the messages.

    Attributes:
        lost: number of messages lost before they reached this node, as counted by the source.
        is_ready: whether the inbox is in `InboxSet.ready`.
    """

    __slots__ = ("_limit", "_newest", "_num_put", "_num_taken", "_queues", "is_ready", "lost", "source")

    def __init__(self, source: Source) -> None:
        self.source = source
        self.lost = 0
        self.is_ready = False
        self._limit: int | None = None
        self._newest: _Queue[Item] = _Queue()
        self._queues: deque[_Queue[Item]] = deque([self._newest])  # each change of the limit adds a queue
        self._num_put = self._num_taken = 0

    def __len__(self) -> int:
        return sum(map(len, list(self._queues)))

    @property
    def dropped(self) -> int:
        """Number of messages lost so far, in this inbox or before it; may briefly be one too low, never too high."""
        # Read in this order, since other threads add and take messages.
        return self.lost + max(0, self._num_put - len(self) - self._num_taken)

    def is_full(self, limit: int) -> bool:
        """Return whether the next message will replace an older one."""
        return len(self._newest) >= limit

    def put(self, item: Item, limit: int | None) -> None:
        """Add a message. Called by one thread at a time.

        Args:
            item: the message.
            limit: maximum number of waiting messages, beyond which the oldest are dropped; 0 or None for no limit.
        """
        if limit != self._limit:
            self._limit = limit
            newest: _Queue[Item] = _Queue(maxlen=limit or None)
            self._queues.append(newest)  # from now on nothing is put into the earlier queues
            self._newest = newest
        self._newest.append(item)
        self._num_put += 1

    def take(self) -> Item | None:
        """Remove the oldest message and return it; None if there is none."""
        while True:
            queue = self._queues[0]
            is_newest = queue is self._newest  # checked first: only the newest queue can still get messages
            self._num_taken += 1  # first: a message that is being taken does not count as lost
            try:
                return queue.popleft()
            except IndexError:
                self._num_taken -= 1
                if is_newest:
                    return None
                with contextlib.suppress(ValueError):  # if another thread takes messages as well
                    self._queues.remove(queue)


class InboxSet:
    """The inboxes of a delivery loop, or of an asynchronous iteration.

    Attributes:
        ready: inboxes with messages, in the order of their turns.
        inboxes: all inboxes.
    """

    def __init__(self) -> None:
        self.ready: list[Inbox] = []  # usually short, so not a deque; see `DeliveryLoop`
        self.inboxes: dict[Inbox, None] = {}
        self._dropped = 0  # number of messages lost in removed inboxes
        self._room = Condition()

    def __len__(self) -> int:
        return sum(map(len, list(self.inboxes)))

    @property
    def dropped(self) -> int:
        """Number of messages lost so far, in all inboxes."""
        return self._dropped + sum(inbox.dropped for inbox in list(self.inboxes))

    def add(self, inbox: Inbox) -> None:
        """Start taking messages out of an inbox, until `remove` is called."""
        self.inboxes[inbox] = None

    def mark_ready(self, inbox: Inbox) -> None:
        """Add an inbox with messages to ``ready``, unless it is there already."""
        if not inbox.is_ready:
            inbox.is_ready = True
            self.ready.append(inbox)

    def mark_empty(self, inbox: Inbox) -> bool:
        """Note that an inbox was removed from ``ready`` and emptied. Called by the thread that takes messages.

        If another thread has just put a message into the inbox without noticing this, the inbox becomes ready again.

        Returns:
            Whether the inbox is still empty.
        """
        inbox.is_ready = False
        self._room.notify_all()
        if len(inbox):
            self.mark_ready(inbox)
            return False
        return True

    def remove(self, inbox: Inbox) -> None:
        """Stop taking messages from an inbox. Called by the thread that takes them."""
        if inbox in self.inboxes:
            del self.inboxes[inbox]  # first: its lost messages must not count twice
            self._dropped += inbox.dropped

    def wait_for_room(self, inbox: Inbox, maximum: int, has_ended: Callable[[], bool]) -> None:
        """Wait until fewer than ``maximum`` messages are in an inbox, or ``has_ended`` returns True."""
        while len(inbox) >= maximum and not has_ended():
            self._room.wait_for(lambda: len(inbox) < maximum or has_ended(), 0.1)

    def notify_all(self) -> None:
        """Wake the threads that wait for room."""
        self._room.notify_all()


class Frames:
    """The messages of one receive: frames in a buffer.

    Args:
        link: the link that received them.
        data: the buffer.
        frames: (start, end) of each frame's body.
    """

    __slots__ = ("_position", "data", "frames", "link")

    def __init__(self, link: TcpSource, data: bytes, frames: list[tuple[int, int]]) -> None:
        self.link = link
        self.data = data
        self.frames = frames
        self._position = 0

    def __len__(self) -> int:
        return max(0, len(self.frames) - self._position)

    def deliver(self, receiver: Dispatcher | SpinQueues, count: int) -> bool:
        """Deliver the next messages; return whether any are left.

        Args:
            receiver: receives the messages.
            count: maximum number of messages.
        """
        link, data, deliver_frame, begin = self.link, self.data, receiver.deliver_frame, self._position
        self._position = stop = begin + count
        for start, end in self.frames[begin:stop]:
            deliver_frame(link, data, start, end)
        return stop < len(self.frames)

    def deliver_until(self, receiver: Dispatcher | SpinQueues, deadline: float) -> bool:
        """Deliver messages until a deadline in `perf_counter` seconds; return whether the deadline has passed."""
        link, data, deliver_frame, begin = self.link, self.data, receiver.deliver_frame, self._position
        for stop, (start, end) in enumerate(self.frames[begin:], begin + 1):
            deliver_frame(link, data, start, end)
            if perf_counter() > deadline:
                self._position = stop
                return True
        self._position = len(self.frames)
        return False

    def newest(self, count: int) -> list[bytes]:
        """Return the ``count`` newest of the remaining messages, oldest first."""
        return [self.data[start:end] for start, end in self.frames[self._position :][-count:]]


class Items:
    """The messages of one `receive` that are not frames in a buffer: large ones, and those from shared memory.

    Args:
        link: the link that received them.
        items: the messages.
    """

    __slots__ = ("_items", "link")

    def __init__(self, link: TcpSource, items: Iterable[bytes | SplitBody]) -> None:
        self.link = link
        self._items = deque(items)

    def __len__(self) -> int:
        return len(self._items)

    def deliver(self, receiver: Dispatcher | SpinQueues, count: int) -> bool:
        """Deliver the next messages; see `Frames.deliver`."""
        items = self._items
        for _ in range(min(count, len(items))):
            receiver.deliver_item(self.link, items.popleft())  # so that the memory of delivered messages can be reused
        return bool(items)

    def deliver_until(self, receiver: Dispatcher | SpinQueues, deadline: float) -> bool:
        """Deliver messages until a deadline; see `Frames.deliver_until`."""
        while self._items:
            receiver.deliver_item(self.link, self._items.popleft())
            if perf_counter() > deadline:
                return True
        return False

    def newest(self, count: int) -> list[bytes | SplitBody]:
        """Return the ``count`` newest of the remaining messages, oldest first."""
        return list(self._items)[-count:]


Batch = Frames | Items
"""The messages of one receive."""


class Backlog:
    """The newest messages of each source; the sources take turns.

    Args:
        limit: maximum number of messages to keep of each source.

    Attributes:
        dropped: number of messages that were not kept.
    """

    def __init__(self, limit: int) -> None:
        self.dropped = 0
        self._limit = limit
        self._waiting: dict[Source, deque[Item]] = {}

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def put(self, source: Source, item: Item) -> None:
        """Add a message; if its source has too many, drop the oldest of them."""
        items = self._waiting.get(source)
        if items is None:
            items = self._waiting[source] = deque(maxlen=self._limit)
        self.dropped += len(items) == self._limit
        items.append(item)

    def put_batch(self, batch: Batch) -> None:
        """Add the newest messages of one receive."""
        self.dropped += max(0, len(batch) - self._limit)
        for item in batch.newest(self._limit):
            self.put(batch.link, item)

    def take(self) -> tuple[Source, Item]:
        """Remove the oldest message of the source whose turn it is; return the source and the message."""
        source = next(iter(self._waiting))
        items = self._waiting.pop(source)
        item = items.popleft()
        if items:
            self._waiting[source] = items  # its next turn comes after the other sources'
        return source, item
