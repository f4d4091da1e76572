"""Receives for a subscription, from all its links, and runs the callbacks, or queues them for `spin`.

One thread at a time, of those that the subscriptions of a node share, does so: the *owner*. Who comes with something
to do leaves it in a queue and becomes the owner; or goes away if there is one, which looks at the queues when it ends.

Rules:

* What one system call brought is decoded together, while callbacks keep up. A large byte array is received into the
  object that the callback gets.
* With a bounded queue, callbacks that fall more than FRESH seconds behind see fresh data: what has arrived is drained
  from the sockets, still encoded, and only the newest `limit` frames of each publisher are decoded and delivered.
* Without a bound nothing is dropped here: TCP holds the publisher back, whose queue size then decides. (What waits for
  `spin` is bounded always, see UNBOUNDED_LIMIT.)
* While messages flow on an only link the owner waits in its receive, for PATIENCE seconds at most; all else that may
  happen then waits as long.
* A message that cannot be decoded, or a callback that raises, is logged and costs nothing but itself.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from time import perf_counter
from typing import TYPE_CHECKING, Protocol

from pyros1.errors import ProtocolError
from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.large import SplitBody
from pyros1.node.backlog import Backlog
from pyros1.node.inlink import LARGE, InLink
from pyros1.node.local import UNBOUNDED_LIMIT

if TYPE_CHECKING:
    from collections.abc import Callable

    from pyros1.node.callbacks import CallbackQueue
    from pyros1.node.readers import Readers

FLOWING = 0.02
"""Messages that come faster than every so many seconds flow: a thread of their own delivers them sooner."""
FRESH = 0.001
FLOOD = 30e-6
FEW = 16
LITTLE = 65536
"""Messages that come faster than every FLOOD seconds, FEW with each receive and of LITTLE bytes, FLOOD_RUN_UP times."""
FLOOD_RUN_UP = 100
GATHER = 200e-6
"""Seconds for which a flood is left alone."""
DRAIN_TIME = 0.02
"""Longest time, in seconds, spent on draining sockets before callbacks go on: a flood must not starve them."""


Item = bytes | SplitBody | Message | AnyMsg
"""A message that waits: encoded, or handed over by a publisher in this process."""


class Source(Protocol):
    """Where frames come from: a link to a publisher."""

    header: dict[str, str]

    @property
    def connected(self) -> bool: ...


class Reader:
    """Receives and delivers for one subscription.

    Args:
        readers: the node's threads.
        deliver: called with (source, buffer, start, end) for each frame: decodes and runs the callbacks.
        deliver_item: the same for a message that stands alone, called with (source, item).
        on_lost: called, by the owner, with (link, reason) when a link broke; reason is None for an orderly end.
        on_arrival: in a node that spins, called with (source, item) at once; tells whether to queue the item.
        callbacks: where deliveries are queued, for a node that spins.
    """

    def __init__(
        self,
        readers: Readers,
        deliver: Callable[[Source, bytes, int, int], None],
        deliver_item: Callable[[Source, Item], None],
        on_lost: Callable[[InLink, str | None], None],
        on_arrival: Callable[[Source, Item], bool],
        callbacks: CallbackQueue | None,
    ) -> None:
        self.limit: int | None = None
        self.dropped = 0
        self._readers = readers
        self._deliver = deliver
        self._deliver_item = deliver_item
        self._on_lost = on_lost
        self._on_arrival = on_arrival
        self._callbacks = callbacks
        self._links: dict[int, InLink] = {}
        self._new: deque[InLink] = deque()
        self._readable: deque[int] = deque()
        self._jobs: deque[Callable[[], None]] = deque()
        self._local: deque[tuple[Source, Item]] = deque()
        self._spinning: deque[tuple[Source, Item]] = deque()
        self._queues = threading.Lock()  # of both: taking one out and dropping one must not mix
        self._room = threading.Condition()
        self._ownership = threading.Lock()
        self._owner = 0  # the owner's thread
        self._woken = False  # a thread is on its way
        self._has_local = False
        self._closed = False

    # From other threads -----------------------------------------------------------------------------------------------

    def add(self, link: InLink) -> None:
        """Start to receive from a link."""
        self._new.append(link)
        self._wake()
        if self._closed:
            self.close()

    def submit(self, job: Callable[[], None]) -> None:
        """Run a job between messages."""
        self._jobs.append(job)
        self._wake()

    def _wake(self) -> None:
        if not self._woken and not self._ownership.locked():
            self._woken = True
            self._readers.wake(self)

    def push_local(self, source: Source, item: Item, limit: int | None) -> None:
        """Take a message from a publisher in this process.

        Args:
            limit: the publisher's queue size: 0 unlimited; None: wait until there is room.
        """
        local = self._local
        own = self.limit
        if own is None and limit is None:
            self._wait_for_room()
        self._has_local = True
        most = own if own is not None else limit
        if most and len(local) >= most and self._owner != threading.get_ident():
            time.sleep(0)  # let the owner take them, if all that it waits for is the interpreter's lock
        with self._queues:
            local.append((source, item))
            if most and len(local) > most:
                local.popleft()
                self.dropped += 1
        self._wake()

    def _wait_for_room(self) -> None:
        if self._owner == threading.get_ident():
            return  # a callback that publishes to its own topic would wait for itself
        with self._room:
            while len(self._local) >= UNBOUNDED_LIMIT and not self._closed:
                self._room.wait(0.1)

    def stop(self) -> None:
        """Deliver nothing more; `close` is still to be called."""
        self._closed = True

    def close(self, timeout: float = 5.0) -> None:
        """Close all links; wait for a running callback at most ``timeout`` seconds."""
        self._closed = True
        if self._owner == threading.get_ident():
            return  # a callback ends its own subscription: the owner does the rest
        if self._ownership.acquire(timeout=timeout):
            self._dispose()
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
        while self._new or self._readable or self._jobs or self._local or self._closed:
            if not self._ownership.acquire(blocking=False):
                return  # the owner sees what is there when it has ended
            self._owner = threading.get_ident()
            try:
                self._work()
            except BaseException:
                self._give_back()
                self._readers.wake(self)  # for what was left
                raise
            self._give_back()
            if self._closed:
                return

    def _give_back(self) -> None:
        self._owner = 0
        self._ownership.release()

    def _work(self) -> None:
        while not self._closed and (self._new or self._readable or self._jobs or self._local):
            self._run_jobs()
            while self._new:
                self._add(self._new.popleft())
            while self._readable and not self._jobs:
                self._receive_from(self._readable.popleft())
            if self._local:
                self._take_local()
        if self._closed:
            self._dispose()

    def _run_jobs(self) -> None:
        while self._jobs:
            self._jobs.popleft()()

    def _receive_from(self, fd: int) -> None:
        link = self._links.get(fd)
        if link is None:
            return
        now = perf_counter()
        flowing = now - link.last_time < FLOWING
        link.last_time = now
        try:
            self._receive(link)
            if flowing and link.patient and len(self._links) == 1 and not self._has_local:
                self._stay_with(link)
        finally:  # a link that is neither lost nor waited for would be deaf for ever
            if self._links.get(fd) is link:
                self._readers.rearm(fd)

    def _dispose(self) -> None:
        for link in list(self._links.values()):
            self.drop(link)
        while self._new:
            self._new.popleft().sock.close()
        self._jobs.clear()
        with self._room:
            self._room.notify_all()

    def _add(self, link: InLink) -> None:
        frames = self._open(link)
        if frames:
            self._take(link, frames)

    def _open(self, link: InLink) -> list[tuple[int, int]]:
        """Wait for a new link; return what came together with its header."""
        self._links[link.fd] = link
        self._readers.register(link.fd, self)
        return self._split(link, 0)

    def drop(self, link: InLink) -> None:
        """Close a link, without reporting it as lost. By the owner only."""
        if self._links.pop(link.fd, None) is not None:
            link.connected = False
            self._readers.unregister(link.fd)
            link.sock.close()

    def _lose(self, link: InLink, reason: str | None) -> None:
        if link.fd in self._links:
            self.drop(link)
            self._on_lost(link, reason)

    def _stay_with(self, link: InLink) -> None:
        """While messages flow on the only link, wait in its receive: one system call less for each.

        A publisher that sends each message of a flood by itself wakes this thread for each, which costs the publisher
        more than the sending. So a flood is let gather for a moment.
        """
        few, messages, size, last = 0, link.messages, link.bytes_received, perf_counter()
        while not (self._closed or self._new or self._jobs or self._local) and self._readers.someone_waits:
            if not self._receive(link, wait=True):
                break
            now = perf_counter()
            count, messages = link.messages - messages, link.messages
            if now - last > count * FLOOD or link.bytes_received - size > LITTLE:
                few = 0
            elif count <= FEW:
                few += 1
                if few > FLOOD_RUN_UP:
                    time.sleep(GATHER)
            size, last = link.bytes_received, now

    def _receive(self, link: InLink, wait: bool = False) -> bool:
        """Receive once and deliver; return whether there may be more."""
        frames = self._receive_frames(link, wait)
        if self._jobs:  # they are older than what was waited for: a new subscriber must get it
            self._run_jobs()
        if frames is None:
            return False
        if frames.__class__ is SplitBody:
            self._take_item(link, frames)
        elif frames:
            self._take(link, frames)  # type: ignore[arg-type]  # a list, then
        return True

    def _receive_frames(self, link: InLink, wait: bool = False) -> list[tuple[int, int]] | SplitBody | None:
        try:
            came = link.receive(wait)
        except BlockingIOError:
            return None
        except OSError as error:
            self._lose(link, error.strerror or str(error))
            return None
        if isinstance(came, SplitBody):
            return came
        if not came:
            self._lose(link, None)
            return None
        return self._split(link, came)

    def _split(self, link: InLink, count: int) -> list[tuple[int, int]]:
        link.bytes_received += count
        try:
            frames = link.buffer.received(count)
        except ProtocolError as error:
            self._lose(link, str(error))
            return []
        link.messages += len(frames)
        return frames

    def _take(self, link: InLink, frames: list[tuple[int, int]]) -> None:
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
            for start, end in frames:
                deliver(link, data, start, end)
            return
        behind = perf_counter() + FRESH
        for index, (start, end) in enumerate(frames, 1):
            deliver(link, data, start, end)
            if perf_counter() > behind:
                self.dropped += max(0, len(frames) - index - limit)
                self._catch_up([(link, data[a:b]) for a, b in frames[index:][-limit:]])
                return

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
        while not self._closed:
            self._run_jobs()
            while self._new:
                link = self._new.popleft()
                backlog.put_frames(link, self._open(link))
            for link in list(self._links.values()):
                until = perf_counter() + DRAIN_TIME / (len(self._links) or 1)
                while perf_counter() < until and (frames := self._receive_frames(link)) is not None:
                    backlog.put_frames(link, frames)
            for _ in range(len(self._local)):
                entry = self._next_of(self._local)
                if entry is not None:
                    backlog.put(*entry)
            self.dropped += backlog.dropped
            backlog.dropped = 0
            if not backlog:
                return
            behind = perf_counter() + FRESH
            while backlog and perf_counter() < behind:
                self._deliver_item(*backlog.take())
            if not backlog and perf_counter() < behind:
                return  # callbacks are quick again

    def _next_of(self, queue: deque[tuple[Source, Item]]) -> tuple[Source, Item] | None:
        with self._queues:
            return queue.popleft() if queue else None

    def _take_local(self) -> None:
        for _ in range(len(self._local)):
            entry = self._next_of(self._local)
            if entry is None:
                break
            if self._callbacks is not None:
                self._queue_for_spin(*entry)
            else:
                self._deliver_item(*entry)
        with self._room:
            self._room.notify_all()

    # Nodes that spin --------------------------------------------------------------------------------------------------

    def _queue_for_spin(self, source: Source, item: Item) -> None:
        if not self._on_arrival(source, item):
            return
        limit = UNBOUNDED_LIMIT if self.limit is None else self.limit
        with self._queues:
            self._spinning.append((source, item))
            if limit and len(self._spinning) > limit:
                self._spinning.popleft()
                self.dropped += 1
                return  # the queue holds a callback for each waiting frame already
        if self._callbacks is not None:
            self._callbacks.push(self.deliver_next)

    def deliver_next(self) -> None:
        """Run the callbacks for the oldest waiting frame, in the thread that spins."""
        entry = self._next_of(self._spinning)
        if entry is not None:
            self._deliver_item(*entry)
