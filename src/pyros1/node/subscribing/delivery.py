"""The delivery of a subscription: it receives from all links, and runs the callbacks or queues them for `spin`.

One thread at a time, of those that the subscriptions of a node share, does this: the *owner*. A thread that brings work
puts it into a queue and becomes the owner; or goes on if there is one already, which checks the queues before it ends.

* All messages of one system call are decoded together, while callbacks keep up. A large byte array is received into
  the object that the callback gets.
* Sources take turns: a turn is one receive, or TURN seconds of callbacks if others wait; the rest waits for the next
  turn. New links and other jobs come between the turns. So a source that never pauses does not starve the others.
* With a bounded queue, callbacks that fall more than FRESH seconds behind get fresh data: the sockets are drained,
  and only the newest `limit` frames of each publisher are decoded and delivered.
* Without a bound nothing is dropped here: TCP holds the publisher back, whose queue size then decides. (Queues for
  `spin` are always bounded, see UNBOUNDED_LIMIT.)
* While messages flow on a subscription's only link, the owner waits in its receive, and other work with it.
* While a subscriber with its own queue (`Holding`) has too many messages, nothing is received: TCP holds all back.
* A driver runs all this: threads of the node, or an asyncio loop, which gets its thread back after each round of turns.
* A message that cannot be decoded, or a callback that raises, is logged; delivery goes on with the next message.
"""

from __future__ import annotations

import threading
import time
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
    from pyros1.node.subscribing.drivers import Driver, Holding


class Delivery:
    """Receives and delivers for one subscription.

    Args:
        driver: runs this.
        deliver: called with (source, buffer, start, end) for each frame: decodes and runs the callbacks.
        deliver_item: the same for a message that stands alone, called with (source, item).
        on_lost: called by the owner with (link, reason) when a link has ended; reason is None for an orderly end.
        on_arrival: in a node that spins, called with (source, item) at once; returns whether to queue the item.
        callbacks: the callback queue of a node that spins, else None.

    Attributes:
        limit: most messages of each publisher that may wait for slow callbacks; None for no limit.
        holding: the subscribers that may hold publishers back; replaced as a whole on changes.
        links: its TCP links, with their driver.
    """

    def __init__(
        self,
        driver: Driver,
        deliver: Callable[[Source, bytes, int, int], None],
        deliver_item: Callable[[Source, Item], None],
        on_lost: Callable[[TcpSource, str | None], None],
        on_arrival: Callable[[Source, Item], bool],
        callbacks: CallbackQueue | None,
    ) -> None:
        self.limit: int | None = None
        self.holding: tuple[Holding, ...] = ()
        self._deliver = deliver
        self._deliver_item = deliver_item
        self._on_arrival = on_arrival
        self._callbacks = callbacks
        self._new: deque[TcpSource] = deque()
        self._readable: deque[int] = deque()
        self._jobs: deque[Callable[[], None]] = deque()
        self._begun: deque[Rest] = deque()
        self.handover: Handover[Source, Item] = Handover()
        self._local = self.handover.line
        self._spinning: Spinning[Source, Item] = Spinning(deliver_item)
        self._dropped = 0  # except for those of these two
        self.links = Links(self, driver, self._spinning.forget, on_lost)
        queues = ((self._begun, self._go_on), (self._readable, self._receive_from), (self._local, self._take_from))
        self._queues: tuple[tuple[deque[Any], Callable[[Any], None]], ...] = queues
        self._ownership = threading.Lock()
        self._owner = 0  # the owner's thread
        self._woken = False  # a thread has been woken and will become the owner
        self._closed = self._disposed = False

    # From other threads -----------------------------------------------------------------------------------------------

    def add(self, link: TcpSource) -> None:
        """Start to receive from a link."""
        self._new.append(link)
        self._disposed = False
        self.wake()
        if self._closed:
            self.close()

    def submit(self, job: Callable[[], None], by_callback: bool = False) -> None:
        """Run a job between messages; or now, if it may, and does, come from a callback: that may wait for it."""
        if by_callback and self._owner == threading.get_ident():
            job()
            return
        self._jobs.append(job)
        self.wake()

    def wake(self) -> None:
        """Wake a thread that does the waiting work, unless one is doing it."""
        if not self._woken and not self._ownership.locked():
            self._woken = True
            try:
                self.links.driver.wake(self)
            except BaseException:  # of a signal handler
                self._woken = False
                raise

    @property
    def dropped(self) -> int:
        """Messages lost because callbacks were too slow, or on the way in datagrams."""
        return self._dropped + self.handover.dropped + self._spinning.dropped

    @property
    def waiting(self) -> int:
        """Number of messages that wait in inboxes or for `spin`."""
        return len(self.handover) + len(self._spinning)

    def push(self, inbox: Inbox[Source, Item], item: Item, limit: int | None) -> None:
        """Put a message into an inbox. Never waits; one thread at a time for each inbox.

        Args:
            limit: most messages that wait, if the subscribers have set no limit; 0 or None for no limit.
        """
        own = self.limit
        most = own if own is not None else limit
        if most and inbox.full(most) and self._owner != threading.get_ident():
            self._make_room()
        inbox.put(item, most)
        if not inbox.in_line:
            self.handover.line_up(inbox)
        if not self._woken and not self._ownership.locked():
            self.wake()

    def _make_room(self) -> None:
        """Give the streams what waits in inboxes, in place of the driver's loop, which may be busy for long."""
        if not self.links.driver.cooperative or self._jobs or not self._ownership.acquire(blocking=False):
            time.sleep(0)  # let the owner take them, in case it only waits for the interpreter's lock
            return
        self._owner = threading.get_ident()
        try:
            for _ in range(len(self._local)):
                if self.links.driver.cooperative and not self._held:  # else a callback has joined: not on this thread
                    self._take_from(self._local.popleft())
        finally:
            self._give_back()
            if self._closed:
                self.links.driver.wake(self)

    def open(self, inbox: Inbox[Source, Item]) -> None:
        """Begin to take messages out of an inbox."""
        self.handover.open(inbox)

    def recover(self, inbox: Inbox[Source, Item]) -> None:
        """Look for messages in an inbox, in case its sender was interrupted before it announced them."""
        self.handover.line_up(inbox)
        self.wake()

    def wait_for_room(self, inbox: Inbox[Source, Item]) -> None:
        """Wait until fewer than UNBOUNDED_LIMIT messages wait, if no limit is set."""
        # A callback that publishes to its own topic would wait for itself.
        if self.limit is None and self._owner != threading.get_ident():
            self.handover.wait_for_room(inbox, UNBOUNDED_LIMIT, lambda: self._closed)

    def stop(self) -> None:
        """Deliver nothing more; `close` must still be called."""
        self._closed = True

    def close(self, timeout: float = 5.0, wait: bool = True) -> None:
        """Close all links; wait at most ``timeout`` seconds for a running callback, or let its thread do it later."""
        self._closed = True
        if self._owner == threading.get_ident():
            return  # a callback ends its own subscription: the owner does the rest
        if self._ownership.acquire(timeout=timeout if wait else 0):
            self.links.driver.call(self._dispose, timeout)
            self._ownership.release()

    # By the owner -----------------------------------------------------------------------------------------------------

    def run(self, fd: int | None) -> None:
        """Become the owner, unless there is one, and do all waiting work.

        Args:
            fd: descriptor of a link's socket that can be read.
        """
        if fd is not None:
            self._readable.append(fd)
        self._woken = False
        cooperative = self.links.driver.cooperative
        while not self._disposed if self._closed else self._something:
            if not self._ownership.acquire(blocking=False):
                return  # the owner sees what is there when it has ended
            self._owner = threading.get_ident()
            try:
                self._work()
            except BaseException:
                self._give_back()
                self.links.driver.wake(self)  # for what was left
                raise
            self._give_back()
            if cooperative and not self._closed:
                if self._something:
                    self.wake()
                return

    @property
    def driver(self) -> Driver:
        """What runs this."""
        return self.links.driver

    def _give_back(self) -> None:
        self._owner = 0
        self._ownership.release()

    @property
    def _something(self) -> object:
        """Whether work waits."""
        return self._new or self._jobs or ((self._readable or self._local or self._begun) and not self._held)

    @property
    def _held(self) -> bool:
        """Whether publishers are held back."""
        return any(each.full for each in self.holding) and not any(each.urgent for each in self.holding)

    def _work(self) -> None:
        cooperative = self.links.driver.cooperative
        while not self._closed and self._something:
            self._run_jobs()
            # One turn for each source in line now: others come after them.
            for _ in range(len(self._new)):
                # If callbacks fall behind, `_catch_up` takes the others, too.
                if self._new and (frames := self.links.open(link := self._new.popleft())):
                    self._take(link, frames)
            for queue, go_on in self._queues:
                for _ in range(len(queue)):
                    if self._held:
                        break
                    go_on(queue.popleft())
            self.handover.ring()
            if cooperative:
                break
        if self._closed:
            self._dispose()

    def _run_jobs(self) -> None:
        for _ in range(len(self._jobs)):
            self._jobs.popleft()()

    def _receive_from(self, fd: int) -> None:
        link = self.links.get(fd)
        if link is None or self._is_begun(link):
            return
        now = perf_counter()
        flowing = now - link.last_time < FLOWING
        link.last_time = now
        try:
            self._receive(link)
            if flowing and link.patient and len(self.links) == 1 and not self.handover.inboxes:
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

    def _dispose(self) -> None:
        self._disposed = True
        for link in self.links:
            self.links.close(link)
        while self._new:
            self._new.popleft().close()
        self._jobs.clear()
        self._begun.clear()
        self.handover.ring()

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

    def _take_items(self, link: TcpSource, items: deque[Item]) -> None:
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

    def _deliver_items(self, link: TcpSource, items: deque[Item]) -> None:
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
            link, data, frames, position, items = self._begun.popleft()
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
            link = self._new.popleft()
            backlog.put_frames(link, self.links.open(link))
        for link in self.links:
            until = perf_counter() + DRAIN_TIME / (len(self.links) or 1)
            while perf_counter() < until and (frames := self.links.receive(link)) is not None:
                backlog.put_frames(link, frames)
        for _ in range(len(self._local)):
            inbox = self._local.popleft()
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
