"""The delivery of a subscription: it receives from all links, and runs the callbacks or queues them for `spin`.

One thread at a time, of those that the subscriptions of a node share, does this: the *owner*. A thread with new work
puts it into a queue and becomes the owner, unless there is one already, which checks the queues before it ends.

* All messages of one system call are decoded together, while callbacks keep up. A large byte array is received
  directly into the object that is passed to the callback.
* Sources take turns: a turn is one receive, or TURN seconds of callbacks if other sources wait; the rest waits for the
  next turn. New links and other jobs come between the turns. So a source that never pauses does not starve the rest.
* With a bounded queue, callbacks that fall more than FRESH seconds behind get fresh data: the sockets are drained,
  and only the newest `limit` frames of each publisher are decoded and delivered.
* Without a bound nothing is dropped here: TCP holds the publisher back, whose queue size then decides. (Queues for
  `spin` are always bounded, see UNBOUNDED_LIMIT.)
* While messages flow on a subscription's only link, the owner waits in its receive, which delays other work.
* While a subscriber with its own queue (`StreamState`) has too many messages, nothing is received: TCP holds all
  publishers back.
* A driver runs all this: threads of the node, or an asyncio loop, which gets its thread back after each round of turns.
* If all subscribers want it (`in_publisher`), a message of this process is delivered in its publisher's thread, which
  becomes the owner meanwhile, unless there is an owner or earlier messages wait.
* A message that cannot be decoded, or a callback that raises, is logged; delivery continues with the next message.
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from pyros1.node.subscribing.delivery_loop import DeliveryLoop
from pyros1.node.subscribing.inbox import Inbox
from pyros1.node.subscribing.links import Links
from pyros1.node.subscribing.sources import UNBOUNDED_LIMIT, Item, Source
from pyros1.node.subscribing.tcp_source import TcpSource

if TYPE_CHECKING:
    from collections.abc import Callable

    from pyros1.node.callback_queue import CallbackQueue
    from pyros1.node.subscribing.drivers import Driver


_NONBLOCKING = (False,)


class Delivery(DeliveryLoop):
    """Receives and delivers for one subscription.

    Args:
        driver: runs this.
        deliver: called with (source, buffer, start, end) for each frame: decodes and runs the callbacks.
        deliver_item: the same for a message that stands alone, called with (source, item).
        on_lost: called by the owner with (link, reason) when a link has ended; reason is None for an orderly end.
        on_arrival: in a node that spins, called with (source, item) at once; returns whether to queue the item.
        callbacks: the callback queue of a node that spins, else None.

    Attributes:
        limit: maximum number of messages of each publisher that may wait for slow callbacks; None for no limit.
        streams: the subscribers that may hold publishers back; replaced as a whole on changes.
        in_publisher: whether callbacks run in the threads of publishers of this process.
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
        super().__init__(deliver, deliver_item, on_arrival, callbacks)
        self.in_publisher = False
        self.links = Links(self, driver, self._spin_queues.forget, on_lost)
        self._owner_lock = threading.Lock()
        self._owner = 0  # the owner's thread
        self._is_woken = False  # a thread has been woken and will become the owner
        self._is_disposed = False

    # From other threads -----------------------------------------------------------------------------------------------

    def add(self, link: TcpSource) -> None:
        """Start receiving from a link."""
        self._new_links.append(link)
        self._is_disposed = False
        self.wake()
        if self._closed:
            self.close()

    def submit(self, job: Callable[[], None], by_callback: bool = False) -> None:
        """Run a job between messages; or at once, if that is allowed, for a callback, which may wait for it."""
        if by_callback and self._owner == threading.get_ident():
            job()
            return
        self._jobs.append(job)
        self.wake()

    def wake(self) -> None:
        """Wake a thread to do the pending work, unless one is doing it."""
        if not self._is_woken and not self._owner_lock.locked():
            self._is_woken = True
            try:
                self.links.driver.wake(self)
            except BaseException:  # of a signal handler
                self._is_woken = False
                raise

    @property
    def dropped(self) -> int:
        """Number of messages lost because callbacks were too slow, or in transit as datagrams."""
        return self._dropped + self.inbox_set.dropped + self._spin_queues.dropped

    @property
    def waiting(self) -> int:
        """Number of messages that wait in inboxes or for `spin`."""
        return len(self.inbox_set) + len(self._spin_queues)

    def push(self, inbox: Inbox[Source, Item], item: Item, limit: int | None) -> None:
        """Put a message into an inbox. Never waits; one thread at a time for each inbox.

        Args:
            limit: maximum number of waiting messages, if the subscribers have set no limit; 0 or None for no limit.
        """
        own = self.limit
        maximum = own if own is not None else limit
        if maximum and inbox.full(maximum) and self._owner != threading.get_ident():
            self._drain_inboxes()
        inbox.put(item, maximum)
        if not inbox.is_ready:
            self.inbox_set.mark_ready(inbox)
        if not self._is_woken and not self._owner_lock.locked():
            self.wake()

    def deliver_now(self, source: Source, item: Item) -> bool:
        """Deliver a message in the calling thread, its publisher's; return False if another thread must do it."""
        acquired = False
        try:
            (acquired,) = map(
                self._owner_lock.acquire, _NONBLOCKING
            )  # no signal handler can run between this and the next
            if not acquired or self._closed or not self.in_publisher:
                return False
            self._owner = threading.get_ident()
            if self._jobs:
                if self.links.driver.cooperative:  # they may remove sockets, which only the driver's thread can
                    return False
                self._run_jobs()  # a callback that subscribed before the message was sent gets it
            if self._callbacks is None:
                self._deliver_item(source, item)
            else:
                self._queue_for_spin(source, item)
            return True
        finally:
            if acquired:
                self._owner = 0
                self._owner_lock.release()
                # Nobody was woken for it meanwhile. `_has_work` would take as long as the rest.
                if self._closed:
                    if not self._is_disposed:  # the driver's threads may have ended, if the node has
                        self.close(wait=False)
                elif self._ready_inboxes or self._readable or self._new_links or self._jobs or self._unfinished:
                    self.links.driver.wake(self)

    def _drain_inboxes(self) -> None:
        """Pass messages in inboxes to the streams, in place of the driver's loop, which may be busy for long."""
        if not self.links.driver.cooperative or self._jobs or not self._owner_lock.acquire(blocking=False):
            time.sleep(0)  # let the owner do it, in case it only waits for the interpreter's lock
            return
        self._owner = threading.get_ident()
        try:
            for _ in range(len(self._ready_inboxes)):
                if (
                    self.links.driver.cooperative and not self._is_held_back
                ):  # otherwise a callback has been added: not on this thread
                    self._deliver_from_inbox(self._ready_inboxes.pop(0))
        finally:
            self._release_ownership()
            if self._closed:
                self.links.driver.wake(self)

    def open(self, inbox: Inbox[Source, Item]) -> None:
        """Start taking messages out of an inbox."""
        self.inbox_set.open(inbox)

    def recover(self, inbox: Inbox[Source, Item]) -> None:
        """Look for messages in an inbox, in case its sender was interrupted before it announced them."""
        self.inbox_set.mark_ready(inbox)
        self.wake()

    def wait_for_room(self, inbox: Inbox[Source, Item]) -> None:
        """Wait until fewer than UNBOUNDED_LIMIT messages wait, if no limit is set."""
        # A callback that publishes to its own topic would wait for itself.
        if self.limit is None and self._owner != threading.get_ident():
            self.inbox_set.wait_for_room(inbox, UNBOUNDED_LIMIT, lambda: self._closed)

    def stop(self) -> None:
        """Stop delivering; `close` must still be called."""
        self._closed = True

    def close(self, timeout: float = 5.0, wait: bool = True) -> None:
        """Close all links; wait at most ``timeout`` seconds for a running callback, or leave the rest to its thread."""
        self._closed = True
        if self._owner == threading.get_ident():
            return  # a callback ends its own subscription: the owner does the rest
        if self._owner_lock.acquire(timeout=timeout if wait else 0):
            self.links.driver.call(self._dispose, timeout)
            self._owner_lock.release()

    # By the owner -----------------------------------------------------------------------------------------------------

    def run(self, fd: int | None) -> None:
        """Become the owner, unless there is one, and do all pending work.

        Args:
            fd: descriptor of a link's socket that can be read.
        """
        if fd is not None:
            self._readable.append(fd)
        self._is_woken = False
        cooperative = self.links.driver.cooperative
        while not self._is_disposed if self._closed else self._has_work:
            if not self._owner_lock.acquire(blocking=False):
                return  # the owner checks for it when it has ended
            self._owner = threading.get_ident()
            try:
                self._work()
            except BaseException:
                self._release_ownership()
                self.links.driver.wake(self)  # for what was left
                raise
            self._release_ownership()
            if cooperative and not self._closed:
                if self._has_work:
                    self.wake()
                return

    @property
    def driver(self) -> Driver:
        """The driver that runs this."""
        return self.links.driver

    def _release_ownership(self) -> None:
        self._owner = 0
        self._owner_lock.release()

    def _work(self) -> None:
        cooperative = self.links.driver.cooperative
        while not self._closed and self._has_work:
            self._run_jobs()
            # One turn for each source in line now; sources that are added come after them.
            for _ in range(len(self._new_links)):
                # If callbacks fall behind, `_catch_up` drains the other sources as well.
                if self._new_links and (frames := self.links.open(link := self._new_links.pop(0))):
                    self._deliver_received(link, frames)
            for queue, handle in self._queues:
                for _ in range(len(queue)):
                    if self._is_held_back:
                        break
                    handle(queue.pop(0))
            self.inbox_set.notify_all()
            if cooperative:
                break
        if self._closed:
            self._dispose()

    def _dispose(self) -> None:
        self._is_disposed = True
        for link in self.links:
            self.links.close(link)
        while self._new_links:
            self._new_links.pop(0).close()
        self._jobs.clear()
        self._unfinished.clear()
        self.inbox_set.notify_all()
