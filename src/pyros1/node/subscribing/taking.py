"""What the owner of a delivery does: it takes messages from links and inboxes, and delivers them, in turns.

See `delivery`, whose base this is.
"""

from __future__ import annotations

from collections import deque
from time import perf_counter
from typing import TYPE_CHECKING, Any

from pyros1.msgs.large import SplitBody
from pyros1.node.subscribing.backlog import Backlog
from pyros1.node.subscribing.flood import Flood
from pyros1.node.subscribing.inbox import Handover, Inbox
from pyros1.node.subscribing.links import Links
from pyros1.node.subscribing.sources import UNBOUNDED_LIMIT, Item, Rest, Source
from pyros1.node.subscribing.spin_queues import Spinning
from pyros1.node.subscribing.tcp_source import LARGE, TcpSource
from pyros1.node.subscribing.turns import DRAIN_TIME, EARLY, FLOWING, FRESH, STRIDE, TURN

if TYPE_CHECKING:
    from collections.abc import Callable

    from pyros1.node.callback_queue import CallbackQueue
    from pyros1.node.subscribing.drivers import Holding


class Taking:
    """Takes and delivers the messages of one subscription.

    Args:
        deliver, deliver_item, on_arrival, callbacks: see `delivery.Delivery`.

    Attributes:
        limit, holding, links: see there.
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
        self.holding: tuple[Holding, ...] = ()
        self._deliver = deliver
        self._deliver_item = deliver_item
        self._on_arrival = on_arrival
        self._callbacks = callbacks
        # Lists: they are short, and each deque would take 760 bytes of every subscription.
        self._new: list[TcpSource] = []
        self._readable: list[int] = []
        self._jobs: list[Callable[[], None]] = []
        self._begun: list[Rest] = []
        self.handover: Handover[Source, Item] = Handover()
        self._local = self.handover.line
        self._spinning: Spinning[Source, Item] = Spinning(deliver_item)
        self._dropped = 0  # except for those of these two
        queues = ((self._begun, self._go_on), (self._readable, self._receive_from), (self._local, self._take_from))
        self._queues: tuple[tuple[list[Any], Callable[[Any], None]], ...] = queues
        self._closed = False

    @property
    def _something(self) -> object:
        """Whether work waits."""
        return self._new or self._jobs or ((self._readable or self._local or self._begun) and not self._held)

    @property
    def _held(self) -> bool:
        """Whether publishers are held back."""
        return any(each.full for each in self.holding) and not any(each.urgent for each in self.holding)

    def _run_jobs(self) -> None:
        for _ in range(len(self._jobs)):
            self._jobs.pop(0)()

    def _receive_from(self, fd: int) -> None:
        link = self.links.get(fd)
        if link is None or self._is_begun(link):
            return
        now = perf_counter()
        flowing = now - link.last_time < FLOWING
        link.last_time = now
        try:
            self._receive(link)
            if (flowing or link.eager) and link.patient and len(self.links) == 1 and not self.handover.inboxes:
                self._stay_with(link)
        finally:
            self._rearm(link)

    def _rearm(self, link: TcpSource) -> None:
        """Wait for a link's socket again; a link without a wait, or a turn ahead, would never receive again."""
        if not self._is_begun(link):
            self.links.rearm(link)

    def _is_begun(self, link: TcpSource) -> bool:
        """Return whether a link has received messages that it must deliver before it receives more."""
        return any(rest.link is link for rest in self._begun)

    def _go_on(self, rest: Rest) -> None:
        try:
            if rest.items:
                self._deliver_items(rest.link, rest.items)
            else:
                self._deliver_frames(*rest[:4])
        finally:
            self._rearm(rest.link)

    def _stay_with(self, link: TcpSource) -> None:
        """While messages flow on the only link, wait in its receive: one system call less for each."""
        flood = Flood(link)
        while not (self._closed or self._something or self._begun) and self.links.driver.someone_waits:
            if not self._receive(link, wait=True):
                break
            flood.pause()

    def _receive(self, link: TcpSource, wait: bool = False) -> bool:
        """Receive once and deliver; return whether there may be more."""
        frames = self.links.receive(link, wait)
        if self._jobs:  # these frames are older than the next receive: a new subscriber must get them first
            self._run_jobs()
        if frames is None:
            return False
        if isinstance(frames, SplitBody):
            self._take_item(link, frames)
        elif frames:
            self._take(link, frames)
        return True

    def _take(self, link: TcpSource, frames: list[tuple[int, int]]) -> None:
        if link.items is not None:
            self._take_items(link, link.items)
            return
        if frames[-1][1] > LARGE and len(frames) == 1:  # a single body is not copied again
            self._take_item(link, link.buffer.take_bodies(frames)[0])
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
        behind = perf_counter() + FRESH
        for index, (start, end) in enumerate(frames, 1):
            deliver(link, data, start, end)
            if perf_counter() > behind:
                self._dropped += max(0, len(frames) - index - limit)
                self._catch_up([(link, data[a:b]) for a, b in frames[index:][-limit:]])
                return

    def _take_items(self, link: TcpSource, items: deque[bytes | SplitBody]) -> None:
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
        behind = perf_counter() + FRESH
        while items:
            self._deliver_item(link, items.popleft())
            if perf_counter() > behind:
                self._dropped += max(0, len(items) - limit)
                rest: list[tuple[Source, Item]] = [(link, item) for item in items]
                items.clear()
                self._catch_up(rest[-limit:])
                return

    def _deliver_items(self, link: TcpSource, items: deque[bytes | SplitBody]) -> None:
        """Deliver items; not all, if others wait and the link's turn is over."""
        begun = perf_counter()
        while items and not self._closed:
            over = perf_counter() > begun + TURN and (self._something or self.links.driver.cooperative)
            if over or self._held:
                self._begun.append(Rest(link, b"", [], 0, items))
                return
            self._deliver_item(link, items.popleft())

    def _deliver_frames(self, link: TcpSource, data: bytes, frames: list[tuple[int, int]], position: int) -> None:
        """Deliver the frames from a position on; not all, if others wait and the link's turn is over."""
        deliver, stride, begun = self._deliver, 1, perf_counter()
        while not self._closed:
            for start, end in frames[position : position + stride]:
                deliver(link, data, start, end)
            position += stride
            if position >= len(frames):
                return
            now = perf_counter()
            over = now > begun + TURN and (self._something or self.links.driver.cooperative)
            if over or self._held:
                self._begun.append(Rest(link, data, frames, position))
                return
            if now < begun + EARLY:
                stride = min(2 * stride, STRIDE)

    def _take_item(self, source: Source, item: Item) -> None:
        if self._callbacks is not None:
            self._queue_for_spin(source, item)
            return
        behind = perf_counter() + FRESH
        self._deliver_item(source, item)
        if self.limit is not None and perf_counter() > behind:
            self._catch_up([])

    def _catch_up(self, rest: list[tuple[Source, Item]]) -> None:
        """Deliver the newest messages of each publisher in turn, while callbacks are slower than messages."""
        backlog: Backlog[Source, Item] = Backlog(self.limit or 1)
        for source, item in rest:
            backlog.put(source, item)
        while self._begun:  # from before the queue was bounded
            link, data, frames, position, items = self._begun.pop(0)
            for item in items or (data[start:end] for start, end in frames[position:]):
                backlog.put(link, item)
            self._rearm(link)
        while not self._closed:
            self._gather(backlog)
            self._run_jobs()  # after taking messages: who subscribed before they were sent gets them
            if not backlog:
                return
            behind = perf_counter() + FRESH
            while backlog and perf_counter() < behind:
                self._deliver_item(*backlog.take())
            if not backlog and perf_counter() < behind:
                return  # callbacks keep up again

    def _gather(self, backlog: Backlog[Source, Item]) -> None:
        """Receive what has arrived on all links."""
        for _ in range(len(self._new)):
            link = self._new.pop(0)
            backlog.put_frames(link, self.links.open(link))
        for link in self.links:
            until = perf_counter() + DRAIN_TIME / (len(self.links) or 1)
            while perf_counter() < until and (frames := self.links.receive(link)) is not None:
                backlog.put_frames(link, frames)
        for _ in range(len(self._local)):
            inbox = self._local.pop(0)
            for _ in range(len(inbox)):
                item = inbox.take()
                if item is not None:
                    backlog.put(inbox.source, item)
            self._leave_line(inbox)
        self._dropped += backlog.dropped
        backlog.dropped = 0

    def _take_from(self, inbox: Inbox[Source, Item]) -> None:
        """Give an inbox its turn. It keeps its place, also if a callback raises what nobody catches."""
        deliver = self._deliver_item if self._callbacks is None else self._queue_for_spin
        stride, begun, now = 1, perf_counter(), 0.0
        while now < begun + TURN and not self._held:
            for _ in range(stride):
                item = inbox.take()
                if self._jobs:
                    self._run_jobs()  # as above
                if item is None or self._closed:
                    self._leave_line(inbox)
                    return
                try:
                    deliver(inbox.source, item)
                except BaseException:
                    self._local.append(inbox)
                    raise
            now = perf_counter()
            if now < begun + EARLY:
                stride = min(2 * stride, STRIDE)
        self._local.append(inbox)

    def _leave_line(self, inbox: Inbox[Source, Item]) -> None:
        ended = not inbox.source.connected  # first: a source may put its last messages, and end, just now
        if self.handover.leave_line(inbox) and ended:
            self._forget(inbox)

    def forget(self, source: Source) -> None:
        """Forget a source whose inbox has ended. Called by the owner."""
        for inbox in [each for each in list(self.handover.inboxes) if each.source is source and not len(each)]:
            self._forget(inbox)

    def _forget(self, inbox: Inbox[Source, Item]) -> None:
        self.handover.forget(inbox)
        self._spinning.forget(inbox.source)

    def _queue_for_spin(self, source: Source, item: Item) -> None:
        if not self._on_arrival(source, item):
            return
        call = self._spinning.put(source, item, self.limit or UNBOUNDED_LIMIT)
        if call is not None and self._callbacks is not None:
            self._callbacks.push(call)
