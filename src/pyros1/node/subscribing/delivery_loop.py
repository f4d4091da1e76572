"""The delivery loop of a subscription: it receives from all links and delivers the messages to callbacks.

The subscriptions of a node share a set of threads. At any time at most one of these threads, the *owner*, runs the loop
of a subscription. A thread with new work for the loop appends it to a queue and becomes the owner; if there is an owner
already, that owner checks the queues before it stops. A driver provides the threads: it is either the node's
`DeliveryThreads`, or an asyncio loop, to which this loop returns after each round of turns.

* Sources take turns: a turn is one receive, or MAX_TURN_TIME seconds of callbacks if other sources wait. New links and
  other jobs are handled between turns, so a source that never pauses does not starve the others.
* With a limit on waiting messages, callbacks that fall more than MAX_CALLBACK_TIME seconds behind get fresh data: the
  sockets are drained, and only the newest `limit` messages of each publisher are decoded and delivered.
* Without a limit, this loop drops nothing: while callbacks are slow, it does not read, and the socket fills up. The
  publisher then queues messages, and drops the oldest ones beyond its own queue size.
* While messages flow on a subscription's only link, the owner waits for the next one in `TcpSource.receive` instead of
  the poller. This saves a system call, but delays other work of this loop by up to RECEIVE_TIMEOUT seconds.
* While the queue of a subscriber that has one (`Stream`) is full, nothing is received, so all publishers are held back.
* If all subscribers request it (`in_publisher`), the thread of a publisher in this process becomes the owner and
  delivers its message itself, unless there is an owner already or earlier messages are waiting.
"""

from __future__ import annotations

import threading
import time
from time import perf_counter
from typing import TYPE_CHECKING, Any

from pyros1.node.subscribing.queues import UNBOUNDED_LIMIT, Backlog, Batch, Inbox, InboxSet, Item, Source
from pyros1.node.subscribing.tcp_source import FloodDetector, TcpLinks, TcpSource

if TYPE_CHECKING:
    from collections.abc import Callable

    from pyros1.node.subscribing.dispatcher import Dispatcher, SpinQueues
    from pyros1.node.subscribing.threads import Driver

MAX_FLOW_GAP = 0.02
"""Messages are said to flow if they arrive less than this many seconds apart. If they do, a thread stays with the link,
which delivers them sooner."""
MAX_CALLBACK_TIME = 0.001
"""Seconds that callbacks may take for the messages of one receive; if they take longer, they are too slow."""
MAX_TURN_TIME = 0.002
"""Seconds of callbacks after which it is another source's turn."""
MAX_BATCH = 128
"""Maximum number of messages between two clock readings."""
BATCH_GROWTH_TIME = MAX_TURN_TIME / 8
"""Seconds from the start of a turn during which each clock reading doubles the number of messages until the next."""
_NONBLOCKING = (False,)


class DeliveryLoop:
    """Receives and delivers the messages of one subscription.

    Args:
        dispatcher: passes the messages to the subscribers.
        driver: runs this loop until the links are moved to another driver.
        spin_queues: receives messages in place of the dispatcher, in a node that spins; else None.
        on_lost: called by the owner with (link, reason) when a link has ended; the reason is None for an orderly end.

    Attributes:
        limit: maximum number of messages of each publisher that may wait for slow callbacks; None for no limit.
        in_publisher: whether callbacks run in the threads of publishers of this process.
        links: the TCP links of the subscription.
        inboxes: the inboxes of the other links.
    """

    def __init__(
        self,
        dispatcher: Dispatcher,
        driver: Driver,
        spin_queues: SpinQueues | None,
        on_lost: Callable[[TcpSource, str | None], None],
    ) -> None:
        self.driver = driver
        self.limit: int | None = None
        self.in_publisher = False
        self.links = TcpLinks(self, on_lost)
        self.inboxes = InboxSet()
        self._dispatcher = dispatcher
        self._spin_queues = spin_queues
        self._receiver: Dispatcher | SpinQueues = spin_queues or dispatcher
        # Lists, not deques: they are short, and each deque would take 760 bytes of memory per subscription.
        self._new_links: list[TcpSource] = []
        self._readable: list[int] = []
        self._jobs: list[Callable[[], None]] = []
        self._undelivered: list[Batch] = []
        self._ready_inboxes = self.inboxes.ready
        work_queues = (
            (self._undelivered, self._resume),
            (self._readable, self._receive_from),
            (self._ready_inboxes, self._deliver_from_inbox),
        )
        self._work_queues: tuple[tuple[list[Any], Callable[[Any], None]], ...] = work_queues
        self._dropped = 0  # number of messages, without those that inboxes and spin queues dropped
        self._owner_lock = threading.Lock()
        self._owner_thread_id = 0  # 0 if there is no owner
        self._is_woken = False  # whether a thread has been woken and will become the owner
        self._closed = False
        self._is_disposed = False

    # From other threads -----------------------------------------------------------------------------------------------

    def add(self, link: TcpSource) -> None:
        """Start receiving from a link."""
        self._new_links.append(link)
        self._is_disposed = False
        self.wake()
        if self._closed:
            self.close(wait=False)  # this is called on the node's loop, which must not wait for a callback

    def submit(self, job: Callable[[], None], by_callback: bool = False) -> None:
        """Run a job between messages; or immediately if ``by_callback`` is True and a callback of this loop calls this,
        since the callback may wait for the job.
        """
        if by_callback and self._owner_thread_id == threading.get_ident():
            job()
            return
        self._jobs.append(job)
        self.wake()

    def wake(self) -> None:
        """Wake a thread to do the pending work, unless a thread is already doing it."""
        if not self._is_woken and not self._owner_lock.locked():
            self._is_woken = True
            try:
                self.driver.wake(self)
            except BaseException:  # raised by a signal handler
                self._is_woken = False
                raise

    @property
    def dropped(self) -> int:
        """Number of messages lost so far, because callbacks were too slow or datagrams did not arrive."""
        in_spin_queues = 0 if self._spin_queues is None else self._spin_queues.dropped
        return self._dropped + self.inboxes.dropped + in_spin_queues

    @property
    def waiting(self) -> int:
        """Number of messages that wait in inboxes or for `spin`."""
        return len(self.inboxes) + (0 if self._spin_queues is None else self._spin_queues.waiting)

    def push(self, inbox: Inbox, item: Item, limit: int | None) -> None:
        """Put a message into an inbox. Never waits. Called by one thread at a time for each inbox.

        Args:
            inbox: the inbox.
            item: the message.
            limit: maximum number of waiting messages, if the subscribers have set no limit; 0 or None for no limit.
        """
        own_limit = self.limit
        effective_limit = own_limit if own_limit is not None else limit
        if effective_limit and inbox.is_full(effective_limit) and self._owner_thread_id != threading.get_ident():
            self._drain_inboxes()
        inbox.put(item, effective_limit)
        if not inbox.is_ready:
            self.inboxes.mark_ready(inbox)
        if not self._is_woken and not self._owner_lock.locked():
            self.wake()

    def deliver_now(self, source: Source, item: Item) -> bool:
        """Deliver a message in the publisher's thread, which calls this; return False if another thread must do so."""
        is_acquired = False
        try:
            # `map` prevents that a signal handler runs between `acquire` and the assignment.
            (is_acquired,) = map(self._owner_lock.acquire, _NONBLOCKING)
            if not is_acquired or self._closed or not self.in_publisher:
                return False
            self._owner_thread_id = threading.get_ident()
            if self._jobs:
                if self.driver.cooperative:  # jobs may remove sockets, which only the driver's thread can do
                    return False
                self._run_jobs()  # so that a callback that subscribed before the message was sent receives it
            self._receiver.deliver_item(source, item)
            return True
        finally:
            if is_acquired:
                self._release_ownership()
                # Work that arrived meanwhile has woken no thread, so check for it. (`_has_work` would double the time.)
                if self._closed:
                    if not self._is_disposed:  # the driver's threads, which usually do this, may have exited
                        self.close(wait=False)
                elif self._ready_inboxes or self._readable or self._new_links or self._jobs or self._undelivered:
                    self.driver.wake(self)

    def _drain_inboxes(self) -> None:
        """Pass messages in inboxes to the streams, in place of the driver's thread, which may be busy for a long
        time.
        """
        if not self.driver.cooperative or self._jobs or not self._owner_lock.acquire(blocking=False):
            time.sleep(0)  # let the owner deliver them, in case it is only waiting for the GIL
            return
        self._owner_thread_id = threading.get_ident()
        try:
            for _ in range(len(self._ready_inboxes)):
                # If the driver is no longer cooperative, a callback was added, which must not run on this thread.
                if self.driver.cooperative and not self._dispatcher.is_held_back:
                    self._deliver_from_inbox(self._ready_inboxes.pop(0))
        finally:
            self._release_ownership()
            if self._closed:
                self.driver.wake(self)

    def recover(self, inbox: Inbox) -> None:
        """Look for messages in an inbox, in case the sender was interrupted before it announced them."""
        self.inboxes.mark_ready(inbox)
        self.wake()

    def wait_for_room(self, inbox: Inbox) -> None:
        """Wait until fewer than UNBOUNDED_LIMIT messages are in an inbox, if no limit is set."""
        # A callback that publishes to its own topic would wait for itself.
        if self.limit is None and self._owner_thread_id != threading.get_ident():
            self.inboxes.wait_for_room(inbox, UNBOUNDED_LIMIT, lambda: self._closed)

    def stop(self) -> None:
        """Stop delivering; `close` must still be called."""
        self._closed = True

    def close(self, timeout: float = 5.0, wait: bool = True) -> None:
        """Close all links: later, if a callback or an asyncio loop takes ``timeout`` seconds, or ``wait`` is False."""
        self._closed = True
        if self._owner_thread_id == threading.get_ident():
            return  # a callback ends its own subscription: the owner does the rest
        timeout = timeout if wait else 0.0
        if self._owner_lock.acquire(timeout=timeout):
            self.driver.call(self._dispose, timeout)
            self._owner_lock.release()

    # The owner --------------------------------------------------------------------------------------------------------

    def run(self, fd: int | None) -> None:
        """Become the owner, unless there is one, and do all pending work.

        Args:
            fd: descriptor of a link's socket that is readable; None to do other work only.
        """
        if fd is not None:
            self._readable.append(fd)
        self._is_woken = False
        cooperative = self.driver.cooperative
        while not self._is_disposed if self._closed else self._has_work:
            if not self._owner_lock.acquire(blocking=False):
                return  # the owner checks for work again before it stops
            self._owner_thread_id = threading.get_ident()
            try:
                self._work()
            except BaseException:
                self._release_ownership()
                self.driver.wake(self)  # to run again for the remaining work
                raise
            self._release_ownership()
            if cooperative and not self._closed:
                if self._has_work:
                    self.wake()
                return

    def _release_ownership(self) -> None:
        self._owner_thread_id = 0
        self._owner_lock.release()

    def _work(self) -> None:
        cooperative = self.driver.cooperative
        while not self._closed and self._has_work:
            self._run_jobs()
            # One turn for each source that is queued now; sources that are added get their turn later.
            for _ in range(len(self._new_links)):
                # If callbacks fall behind, `_catch_up` drains the other sources as well.
                if self._new_links and (batch := self.links.open(self._new_links.pop(0))):
                    self._deliver(batch)
            for queue, take_turn in self._work_queues:
                for _ in range(len(queue)):
                    if self._dispatcher.is_held_back:
                        break
                    take_turn(queue.pop(0))
            self.inboxes.notify_all()
            if cooperative:
                break
        if self._closed:
            self._dispose()

    @property
    def _has_work(self) -> object:
        """Whether work is pending."""
        return (
            self._new_links
            or self._jobs
            or ((self._readable or self._ready_inboxes or self._undelivered) and not self._dispatcher.is_held_back)
        )

    def _run_jobs(self) -> None:
        for _ in range(len(self._jobs)):
            self._jobs.pop(0)()

    def forget(self, source: Source) -> None:
        """Forget a source that has ended, unless its inbox still has messages. Called by the owner."""
        self._dispatcher.forget(source)
        for inbox in [other for other in list(self.inboxes.inboxes) if other.source is source]:
            if len(inbox):
                return  # `_mark_empty` calls this again
            self.inboxes.remove(inbox)
        if self._spin_queues is not None:
            self._spin_queues.forget(source)

    def _dispose(self) -> None:
        self._is_disposed = True
        for link in self.links:
            self.links.close(link)
        while self._new_links:
            self._new_links.pop(0).close()
        self._jobs.clear()
        self._undelivered.clear()
        self.inboxes.notify_all()

    # Turns of TCP links -----------------------------------------------------------------------------------------------

    def _receive_from(self, fd: int) -> None:
        link = self.links.get(fd)
        if link is None or self._has_undelivered(link):
            return
        now = perf_counter()
        is_flowing = now - link.last_readable_at < MAX_FLOW_GAP
        link.last_readable_at = now
        try:
            self._receive(link)
            if (is_flowing or link.low_latency) and link.can_wait and len(self.links) == 1 and not self.inboxes.inboxes:
                self._receive_while_flowing(link)
        finally:
            self._rearm(link)

    def _receive_while_flowing(self, link: TcpSource) -> None:
        """While messages flow on the only link, wait in `TcpSource.receive`, which saves a system call per message."""
        flood_detector = FloodDetector(link)
        while not (self._closed or self._has_work or self._undelivered) and self.driver.has_waiting_thread:
            if not self._receive(link, wait=True):
                break
            flood_detector.pause()

    def _receive(self, link: TcpSource, wait: bool = False) -> bool:
        """Receive once and deliver; return whether more may be available."""
        batch = self.links.receive(link, wait)
        if self._jobs:  # before delivery: a subscriber that a job activates must get these messages
            self._run_jobs()
        if batch is None:
            return False
        self._deliver(batch)
        return True

    def _resume(self, batch: Batch) -> None:
        try:
            self._deliver_in_turn(batch)
        finally:
            self._rearm(batch.link)

    def _rearm(self, link: TcpSource) -> None:
        """Wait for a link's socket again, unless the link has undelivered messages: `_resume` then does this later."""
        if not self._has_undelivered(link):
            self.links.rearm(link)

    def _has_undelivered(self, link: TcpSource) -> bool:
        """Return whether a link has received messages that it must deliver before it receives more."""
        return any(batch.link is link for batch in self._undelivered)

    def _deliver(self, batch: Batch) -> None:
        """Deliver the messages that a link has just received, or queue them for `spin`."""
        limit = self.limit
        if self._spin_queues is not None:
            batch.deliver(self._receiver, len(batch))
        elif limit is None:
            self._deliver_in_turn(batch)
        elif batch.deliver_until(self._receiver, perf_counter() + MAX_CALLBACK_TIME):
            self._catch_up(batch, limit)

    def _deliver_in_turn(self, batch: Batch) -> None:
        """Deliver messages until the link's turn is over and other sources are waiting."""
        count, start = 1, perf_counter()
        while not self._closed and batch.deliver(self._receiver, count):
            now = perf_counter()
            is_turn_over = now > start + MAX_TURN_TIME and (self._has_work or self.driver.cooperative)
            if is_turn_over or self._dispatcher.is_held_back:
                self._undelivered.append(batch)
                return
            if now < start + BATCH_GROWTH_TIME:
                count = min(2 * count, MAX_BATCH)

    # Slow callbacks ---------------------------------------------------------------------------------------------------

    def _catch_up(self, batch: Batch, limit: int) -> None:
        """Deliver the newest messages of each publisher in turn, while messages arrive faster than callbacks run."""
        backlog = Backlog(limit)
        backlog.put_batch(batch)
        while self._undelivered:  # queued before there was a limit
            backlog.put_batch(earlier_batch := self._undelivered.pop(0))
            self._rearm(earlier_batch.link)
        while not self._closed:
            self._drain_all(backlog)
            self._run_jobs()  # after draining: a new subscriber gets messages that were sent after it subscribed
            if not backlog:
                return
            deadline = perf_counter() + MAX_CALLBACK_TIME
            while backlog and perf_counter() < deadline:
                self._receiver.deliver_item(*backlog.take())
            if not backlog and perf_counter() < deadline:
                return  # callbacks keep up again

    def _drain_all(self, backlog: Backlog) -> None:
        """Put the messages that have arrived on all links into the backlog."""
        for _ in range(len(self._new_links)):
            if (batch := self.links.open(self._new_links.pop(0))) is not None:
                backlog.put_batch(batch)
        self.links.drain(backlog)
        for _ in range(len(self._ready_inboxes)):
            inbox = self._ready_inboxes.pop(0)
            for _ in range(len(inbox)):
                item = inbox.take()
                if item is not None:
                    backlog.put(inbox.source, item)
            self._mark_empty(inbox)
        self._dropped += backlog.dropped
        backlog.dropped = 0

    # Turns of inboxes -------------------------------------------------------------------------------------------------

    def _deliver_from_inbox(self, inbox: Inbox) -> None:
        """Deliver messages from an inbox for one turn. If a callback raises an exception that is not caught, its
        message is lost, but the inbox stays in `_ready_inboxes`, so that its other messages get their turn.
        """
        deliver_item = self._receiver.deliver_item
        batch_size, start, now = 1, perf_counter(), 0.0
        while now < start + MAX_TURN_TIME and not self._dispatcher.is_held_back:
            for _ in range(batch_size):
                item = inbox.take()
                if self._jobs:
                    self._run_jobs()  # before delivery, as in `_receive`
                if item is None or self._closed:
                    self._mark_empty(inbox)
                    return
                try:
                    deliver_item(inbox.source, item)
                except BaseException:
                    self._ready_inboxes.append(inbox)
                    raise
            now = perf_counter()
            if now < start + BATCH_GROWTH_TIME:
                batch_size = min(2 * batch_size, MAX_BATCH)
        self._ready_inboxes.append(inbox)

    def _mark_empty(self, inbox: Inbox) -> None:
        # read before the inbox: the source may be adding its last messages and ending right now
        has_ended = not inbox.source.connected
        if self.inboxes.mark_empty(inbox) and has_ended:
            self.forget(inbox.source)
