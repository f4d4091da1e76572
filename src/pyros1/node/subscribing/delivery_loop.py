"""The work of a delivery's owner: it takes messages from links and inboxes, and delivers them, in turns.

See `delivery`, whose base this is.
"""

from __future__ import annotations

from collections import deque
from time import perf_counter
from typing import TYPE_CHECKING, Any

from pyros1.msgs.large_arrays import SplitBody
from pyros1.node.subscribing.backlog import Backlog
from pyros1.node.subscribing.flood_detector import FloodDetector
from pyros1.node.subscribing.inbox import Inbox, InboxSet
from pyros1.node.subscribing.links import Links
from pyros1.node.subscribing.sources import UNBOUNDED_LIMIT, Item, Source, Unfinished
from pyros1.node.subscribing.spin_queues import SpinQueues
from pyros1.node.subscribing.tcp_source import MIN_LARGE_FRAME, TcpSource
from pyros1.node.subscribing.time_slices import (
    BATCH_GROWTH_TIME,
    DRAIN_TIME,
    MAX_BATCH,
    MAX_CALLBACK_TIME,
    MAX_FLOW_GAP,
    MAX_TURN_TIME,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from pyros1.node.callback_queue import CallbackQueue
    from pyros1.node.subscribing.drivers import StreamState


class DeliveryLoop:
    """Takes and delivers the messages of one subscription.

    Args:
        deliver, deliver_item, on_arrival, callbacks: see `delivery.Delivery`.

    Attributes:
        limit, streams, links: see there.
    """

    links: Links

    def __init__(
        self,
        deliver: Callable[[Source, bytes, int, int], None],
        deliver_item: Callable[[Source, Item], None],
        on_arrival: Callable[[Source, Item], bool],
        callbacks: CallbackQueue | None,
    ) -> None:
        self.limit: int | None = None
        self.streams: tuple[StreamState, ...] = ()
        self._deliver = deliver
        self._deliver_item = deliver_item
        self._on_arrival = on_arrival
        self._callbacks = callbacks
        # Lists: they are short, and each deque would take 760 bytes of every subscription.
        self._new_links: list[TcpSource] = []
        self._readable: list[int] = []
        self._jobs: list[Callable[[], None]] = []
        self._unfinished: list[Unfinished] = []
        self.inbox_set: InboxSet[Source, Item] = InboxSet()
        self._ready_inboxes = self.inbox_set.ready
        self._spin_queues: SpinQueues[Source, Item] = SpinQueues(deliver_item)
        self._dropped = 0  # except for those of these two
        queues = (
            (self._unfinished, self._resume),
            (self._readable, self._receive_from),
            (self._ready_inboxes, self._deliver_from_inbox),
        )
        self._queues: tuple[tuple[list[Any], Callable[[Any], None]], ...] = queues
        self._closed = False

    @property
    def _has_work(self) -> object:
        """Whether work is pending."""
        return (
            self._new_links
            or self._jobs
            or ((self._readable or self._ready_inboxes or self._unfinished) and not self._is_held_back)
        )

    @property
    def _is_held_back(self) -> bool:
        """Whether publishers are held back."""
        return any(each.full for each in self.streams) and not any(each.urgent for each in self.streams)

    def _run_jobs(self) -> None:
        for _ in range(len(self._jobs)):
            self._jobs.pop(0)()

    def _receive_from(self, fd: int) -> None:
        link = self.links.get(fd)
        if link is None or self._is_unfinished(link):
            return
        now = perf_counter()
        flowing = now - link.last_time < MAX_FLOW_GAP
        link.last_time = now
        try:
            self._receive(link)
            if (flowing or link.spins) and link.can_wait and len(self.links) == 1 and not self.inbox_set.inboxes:
                self._receive_while_flowing(link)
        finally:
            self._rearm(link)

    def _rearm(self, link: TcpSource) -> None:
        """Wait for a link's socket again; a link without a wait, or a turn ahead, would never receive again."""
        if not self._is_unfinished(link):
            self.links.rearm(link)

    def _is_unfinished(self, link: TcpSource) -> bool:
        """Return whether a link has received messages that it must deliver before it receives more."""
        return any(unfinished.link is link for unfinished in self._unfinished)

    def _resume(self, unfinished: Unfinished) -> None:
        try:
            if unfinished.items:
                self._deliver_items(unfinished.link, unfinished.items)
            else:
                self._deliver_frames(*unfinished[:4])
        finally:
            self._rearm(unfinished.link)

    def _receive_while_flowing(self, link: TcpSource) -> None:
        """While messages flow on the only link, wait in its receive: one system call less for each."""
        flood = FloodDetector(link)
        while not (self._closed or self._has_work or self._unfinished) and self.links.driver.has_waiting_thread:
            if not self._receive(link, wait=True):
                break
            flood.pause()

    def _receive(self, link: TcpSource, wait: bool = False) -> bool:
        """Receive once and deliver; return whether more may be available."""
        frames = self.links.receive(link, wait)
        if self._jobs:  # these frames are older than the next receive: a new subscriber must get them first
            self._run_jobs()
        if frames is None:
            return False
        if isinstance(frames, SplitBody):
            self._deliver_received_item(link, frames)
        elif frames:
            self._deliver_received(link, frames)
        return True

    def _deliver_received(self, link: TcpSource, frames: list[tuple[int, int]]) -> None:
        if link.items is not None:
            self._deliver_received_items(link, link.items)
            return
        if frames[-1][1] > MIN_LARGE_FRAME and len(frames) == 1:  # a single body is not copied again
            self._deliver_received_item(link, link.buffer.take_bodies(frames)[0])
            return
        data = link.buffer.take(frames)
        if self._callbacks is not None:
            for start, end in frames:
                self._queue_for_spin(link, data[start:end])
            return
        deliver, limit = self._deliver, self.limit
        if limit is None:
            self._deliver_frames(link, data, frames, 0)
            return
        slow_after = perf_counter() + MAX_CALLBACK_TIME
        for index, (start, end) in enumerate(frames, 1):
            deliver(link, data, start, end)
            if perf_counter() > slow_after:
                self._dropped += max(0, len(frames) - index - limit)
                self._catch_up([(link, data[a:b]) for a, b in frames[index:][-limit:]])
                return

    def _deliver_received_items(self, link: TcpSource, items: deque[bytes | SplitBody]) -> None:
        """Deliver messages some of which are not in the link's buffer."""
        link.items = None
        if self._callbacks is not None:
            while items:
                self._queue_for_spin(link, items.popleft())
            return
        limit = self.limit
        if limit is None:
            self._deliver_items(link, items)
            return
        slow_after = perf_counter() + MAX_CALLBACK_TIME
        while items:
            self._deliver_item(link, items.popleft())
            if perf_counter() > slow_after:
                self._dropped += max(0, len(items) - limit)
                unfinished: list[tuple[Source, Item]] = [(link, item) for item in items]
                items.clear()
                self._catch_up(unfinished[-limit:])
                return

    def _deliver_items(self, link: TcpSource, items: deque[bytes | SplitBody]) -> None:
        """Deliver items; not all, if other sources wait and the link's turn is over."""
        start = perf_counter()
        while items and not self._closed:
            is_turn_over = perf_counter() > start + MAX_TURN_TIME and (self._has_work or self.links.driver.cooperative)
            if is_turn_over or self._is_held_back:
                self._unfinished.append(Unfinished(link, b"", [], 0, items))
                return
            self._deliver_item(link, items.popleft())

    def _deliver_frames(self, link: TcpSource, data: bytes, frames: list[tuple[int, int]], position: int) -> None:
        """Deliver the frames from a position on; not all, if other sources wait and the link's turn is over."""
        deliver, batch, start = self._deliver, 1, perf_counter()
        while not self._closed:
            for start, end in frames[position : position + batch]:
                deliver(link, data, start, end)
            position += batch
            if position >= len(frames):
                return
            now = perf_counter()
            is_turn_over = now > start + MAX_TURN_TIME and (self._has_work or self.links.driver.cooperative)
            if is_turn_over or self._is_held_back:
                self._unfinished.append(Unfinished(link, data, frames, position))
                return
            if now < start + BATCH_GROWTH_TIME:
                batch = min(2 * batch, MAX_BATCH)

    def _deliver_received_item(self, source: Source, item: Item) -> None:
        if self._callbacks is not None:
            self._queue_for_spin(source, item)
            return
        slow_after = perf_counter() + MAX_CALLBACK_TIME
        self._deliver_item(source, item)
        if self.limit is not None and perf_counter() > slow_after:
            self._catch_up([])

    def _catch_up(self, unfinished: list[tuple[Source, Item]]) -> None:
        """Deliver the newest messages of each publisher in turn, while callbacks are slower than messages."""
        backlog: Backlog[Source, Item] = Backlog(self.limit or 1)
        for source, item in unfinished:
            backlog.put(source, item)
        while self._unfinished:  # from before the queue was bounded
            link, data, frames, position, items = self._unfinished.pop(0)
            for item in items or (data[start:end] for start, end in frames[position:]):
                backlog.put(link, item)
            self._rearm(link)
        while not self._closed:
            self._drain_links(backlog)
            self._run_jobs()  # after taking messages: a callback that subscribed before they were sent gets them
            if not backlog:
                return
            slow_after = perf_counter() + MAX_CALLBACK_TIME
            while backlog and perf_counter() < slow_after:
                self._deliver_item(*backlog.take())
            if not backlog and perf_counter() < slow_after:
                return  # callbacks keep up again

    def _drain_links(self, backlog: Backlog[Source, Item]) -> None:
        """Receive what has arrived on all links."""
        for _ in range(len(self._new_links)):
            link = self._new_links.pop(0)
            backlog.put_frames(link, self.links.open(link))
        for link in self.links:
            deadline = perf_counter() + DRAIN_TIME / (len(self.links) or 1)
            while perf_counter() < deadline and (frames := self.links.receive(link)) is not None:
                backlog.put_frames(link, frames)
        for _ in range(len(self._ready_inboxes)):
            inbox = self._ready_inboxes.pop(0)
            for _ in range(len(inbox)):
                item = inbox.take()
                if item is not None:
                    backlog.put(inbox.source, item)
            self._mark_empty(inbox)
        self._dropped += backlog.dropped
        backlog.dropped = 0

    def _deliver_from_inbox(self, inbox: Inbox[Source, Item]) -> None:
        """Give an inbox its turn. It keeps its place even if a callback raises an exception that is not caught."""
        deliver = self._deliver_item if self._callbacks is None else self._queue_for_spin
        batch, start, now = 1, perf_counter(), 0.0
        while now < start + MAX_TURN_TIME and not self._is_held_back:
            for _ in range(batch):
                item = inbox.take()
                if self._jobs:
                    self._run_jobs()  # as above
                if item is None or self._closed:
                    self._mark_empty(inbox)
                    return
                try:
                    deliver(inbox.source, item)
                except BaseException:
                    self._ready_inboxes.append(inbox)
                    raise
            now = perf_counter()
            if now < start + BATCH_GROWTH_TIME:
                batch = min(2 * batch, MAX_BATCH)
        self._ready_inboxes.append(inbox)

    def _mark_empty(self, inbox: Inbox[Source, Item]) -> None:
        ended = not inbox.source.connected  # first: a source may just be adding its last messages and ending
        if self.inbox_set.mark_empty(inbox) and ended:
            self._forget(inbox)

    def forget(self, source: Source) -> None:
        """Remove a source whose inbox has ended. Called by the owner."""
        for inbox in [each for each in list(self.inbox_set.inboxes) if each.source is source and not len(each)]:
            self._forget(inbox)

    def _forget(self, inbox: Inbox[Source, Item]) -> None:
        self.inbox_set.forget(inbox)
        self._spin_queues.forget(inbox.source)

    def _queue_for_spin(self, source: Source, item: Item) -> None:
        if not self._on_arrival(source, item):
            return
        call = self._spin_queues.put(source, item, self.limit or UNBOUNDED_LIMIT)
        if call is not None and self._callbacks is not None:
            self._callbacks.push(call)
