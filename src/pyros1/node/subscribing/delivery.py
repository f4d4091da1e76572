"""Receives for a subscription, from all its links, and runs the callbacks, or queues them for `spin`.

One thread at a time, of those that the subscriptions of a node share, does so: the *owner*. Who comes with something
to do leaves it in a queue and becomes the owner; or goes away if there is one, which looks at the queues when it ends.

Rules:

* What one system call brought is decoded together, while callbacks keep up. A large byte array is received into the
  object that the callback gets.
* Sources take turns: a turn is one receive, or TURN seconds of callbacks if others wait; what is left has its next turn
  after theirs. New links and other jobs come between the turns. So nobody is kept waiting by those who never pause.
* With a bounded queue, callbacks that fall more than FRESH seconds behind see fresh data: what has arrived is drained
  from the sockets, still encoded, and only the newest `limit` frames of each publisher are decoded and delivered.
* Without a bound nothing is dropped here: TCP holds the publisher back, whose queue size then decides. (What waits for
  `spin` is bounded always, see UNBOUNDED_LIMIT.)
* While messages flow on an only link the owner waits in its receive, for PATIENCE seconds at most; all else that may
  happen then waits as long.
* While a subscriber that has a queue of its own holds too many messages, nothing is received: TCP holds the publishers
  back (see `Holding`).
* A driver runs all this: threads of the node, or an asyncio loop, which gets its thread back after each round of turns.
* A message that cannot be decoded, or a callback that raises, is logged and costs nothing but itself.
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
        on_lost: called, by the owner, with (link, reason) when a link broke; reason is None for an orderly end.
        on_arrival: in a node that spins, called with (source, item) at once; tells whether to queue the item.
        callbacks: where deliveries are queued, for a node that spins.

    Attributes:
        limit: messages of each publisher that may wait for slow callbacks; None for no limit.
        holding: those who may hold publishers back; changed by whole replacement.
        links: its TCP links, and what drives it.
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
        self._dropped = 0  # but for those of these two
        self.links = Links(self, driver, self._spinning.forget, on_lost)
        self._queues: tuple[tuple[deque[Any], Callable[[Any], None]], ...] = (
            (self._begun, self._go_on),
            (self._readable, self._receive_from),
            (self._local, self._take_from),
        )
        self._ownership = threading.Lock()
        self._owner = 0  # the owner's thread
        self._woken = False  # a thread is on its way
        self._closed = False

    # From other threads -----------------------------------------------------------------------------------------------

    def add(self, link: TcpSource) -> None:
        """Start to receive from a link."""
        self._new.append(link)
        self.wake()
        if self._closed:
            self.close()

    def submit(self, job: Callable[[], None]) -> None:
        """Run a job between messages."""
        self._jobs.append(job)
        self.wake()

    def wake(self) -> None:
        """Let a thread look for what there is to do, unless one is at it."""
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
        """Messages handed over, or for `spin`, that wait."""
        return len(self.handover) + len(self._spinning)

    def push(self, inbox: Inbox[Source, Item], item: Item, limit: int | None) -> None:
        """Take a message that is handed over. Never waits; one thread at a time for each inbox.

        Args:
            limit: most that wait, if the subscribers have not said it; 0 or None for no limit.
        """
        own = self.limit
        most = own if own is not None else limit
        if most and inbox.full(most) and self._owner != threading.get_ident():
            time.sleep(0)  # let the owner take them, if all that it waits for is the interpreter's lock
        inbox.put(item, most)
        if not inbox.in_line:
            self.handover.line_up(inbox)
        if not self._woken and not self._ownership.locked():
            self.wake()

    def open(self, inbox: Inbox[Source, Item]) -> None:
        """Take messages out of an inbox from now on."""
        self.handover.open(inbox)

    def recover(self, inbox: Inbox[Source, Item]) -> None:
        """Look for what waits in an inbox, in case that was not said."""
        self.handover.line_up(inbox)
        self.wake()

    def wait_for_room(self, inbox: Inbox[Source, Item]) -> None:
        """Wait until fewer than UNBOUNDED_LIMIT messages wait, if nobody has set a limit."""
        # A callback that publishes to its own topic would wait for itself.
        if self.limit is None and self._owner != threading.get_ident():
            self.handover.wait_for_room(inbox, UNBOUNDED_LIMIT, lambda: self._closed)

    def stop(self) -> None:
        """Deliver nothing more; `close` is still to be called."""
        self._closed = True

    def close(self, timeout: float = 5.0) -> None:
        """Close all links; wait for a running callback at most ``timeout`` seconds."""
        self._closed = True
        if self._owner == threading.get_ident():
            return  # a callback ends its own subscription: the owner does the rest
        if self._ownership.acquire(timeout=timeout):
            self.links.driver.call(self._dispose, timeout)
            self._ownership.release()

    # By the owner -----------------------------------------------------------------------------------------------------

    def run(self, fd: int | None) -> None:
        """Become the owner, if there is none, and do all there is to do.

        Args:
            fd: a link's socket that can be read.
        """
        if fd is not None:
            self._readable.append(fd)
        self._woken = False
        cooperative = self.links.driver.cooperative
        while self._something or self._closed:
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
            if self._closed:
                return
            if cooperative:
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
        """Whether there is something to do."""
        if self._new or self._jobs:
            return True
        return (self._readable or self._local or self._begun) and not self._held

    @property
    def _held(self) -> bool:
        """Whether publishers are held back."""
        holding = self.holding
        return bool(holding) and any(each.full for each in holding) and not any(each.urgent for each in holding)

    def _work(self) -> None:
        cooperative = self.links.driver.cooperative
        while not self._closed and self._something:
            self._run_jobs()
            # One turn for each that is there by now: whoever comes meanwhile comes after them.
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
        """Wait for a link again: one that is neither lost nor waited for, nor has its turn to come, would be deaf."""
        if not self._is_begun(link):
            self.links.rearm(link)

    def _is_begun(self, link: TcpSource) -> bool:
        """Whether a link still has to deliver what it has received: until then, it receives nothing."""
        return any(rest.link is link for rest in self._begun)

    def _go_on(self, rest: Rest) -> None:
        try:
            self._deliver_frames(*rest)
        finally:
            self._rearm(rest.link)

    def _dispose(self) -> None:
        for link in self.links:
            self.links.close(link)
        while self._new:
            self._new.popleft().sock.close()
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
        if self._jobs:  # they are older than what was waited for: a new subscriber must get it
            self._run_jobs()
        if frames is None:
            return False
        if frames.__class__ is SplitBody:
            self._take_item(link, frames)
        elif frames:
            self._take(link, frames)  # type: ignore[arg-type]  # a list, then
        return True

    def _take(self, link: TcpSource, frames: list[tuple[int, int]]) -> None:
        if frames[-1][1] > LARGE and len(frames) == 1:  # a body that stands alone is not copied again
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

    def _deliver_frames(self, link: TcpSource, data: bytes, frames: list[tuple[int, int]], position: int) -> None:
        """Deliver all frames from a position on; or some, if others wait and the link's turn is over."""
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
            link, data, frames, position = self._begun.popleft()
            for start, end in frames[position:]:
                backlog.put(link, data[start:end])
            self._rearm(link)
        while not self._closed:
            self._run_jobs()
            self._gather(backlog)
            if not backlog:
                return
            behind = perf_counter() + FRESH
            while backlog and perf_counter() < behind:
                self._deliver_item(*backlog.take())
            if not backlog and perf_counter() < behind:
                return  # callbacks are quick again

    def _gather(self, backlog: Backlog[Source, Item]) -> None:
        """Take what has arrived, from all."""
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

    # Messages that are handed over -----------------------------------------------------------------------------------

    def _take_from(self, inbox: Inbox[Source, Item]) -> None:
        """Give an inbox its turn."""
        deliver = self._deliver_item if self._callbacks is None else self._queue_for_spin
        stride, begun, now = 1, perf_counter(), 0.0
        while now < begun + TURN and not self._held:
            for _ in range(stride):
                item = inbox.take()
                if item is None or self._closed:
                    self._leave_line(inbox)
                    return
                deliver(inbox.source, item)
            now = perf_counter()
            if now < begun + EARLY:
                stride = min(2 * stride, STRIDE)
        self._local.append(inbox)

    def _leave_line(self, inbox: Inbox[Source, Item]) -> None:
        if self.handover.leave_line(inbox) and not inbox.source.connected:
            self._forget(inbox)

    def forget(self, source: Source) -> None:
        """A source that hands over its messages has ended. By the owner."""
        for inbox in list(self.handover.inboxes):
            if inbox.source is source and not len(inbox):
                self._forget(inbox)

    def _forget(self, inbox: Inbox[Source, Item]) -> None:
        self.handover.forget(inbox)
        self._spinning.forget(inbox.source)

    # Nodes that spin --------------------------------------------------------------------------------------------------

    def _queue_for_spin(self, source: Source, item: Item) -> None:
        if not self._on_arrival(source, item):
            return
        call = self._spinning.put(source, item, self.limit or UNBOUNDED_LIMIT)
        if call is not None and self._callbacks is not None:
            self._callbacks.push(call)
