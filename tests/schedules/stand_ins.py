"""Stand-ins for the modules `threading`, `queue` and `time`, whose waits a scheduler controls.

They have what the modules under test use, and fall back on the real modules for names that do not wait.
"""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from .scheduler import Scheduler

WALL = 1_700_000_000.0


class Lock:
    """As threading.Lock."""

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        self._now = now
        self._taken = False

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take the lock."""
        scheduler = self._now()
        if not blocking:
            scheduler.point()
        elif not scheduler.wait(lambda: not self._taken, None if timeout < 0 else timeout):
            return False
        if self._taken:
            return False
        self._taken = True
        return True

    def release(self) -> None:
        """Free the lock."""
        if not self._taken:
            raise RuntimeError("release unlocked lock")
        self._taken = False
        if not self._now().over:
            self._now().point()

    def locked(self) -> bool:
        """Return whether it is taken."""
        return self._taken

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


class RLock:
    """As threading.RLock."""

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        self._now = now
        self._owner: object = None
        self._count = 0

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take the lock, perhaps once more."""
        scheduler = self._now()
        me = scheduler.current
        if self._owner is not me:
            if not blocking:
                scheduler.point()
            elif not scheduler.wait(lambda: self._owner is None, None if timeout < 0 else timeout):
                return False
            if self._owner is not None:
                return False
        self._owner = me
        self._count += 1
        return True

    def release(self) -> None:
        """Free the lock, if it was taken once."""
        if self._now().over:
            return
        if self._owner is not self._now().current:
            raise RuntimeError("cannot release un-acquired lock")
        self._count -= 1
        if not self._count:
            self._owner = None
            self._now().point()

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


class Condition(RLock):
    """As threading.Condition with a lock of its own."""

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        super().__init__(now)
        self._waiters: list[list[bool]] = []

    def wait(self, timeout: float | None = None) -> bool:
        """Free the lock, wait to be told, and take the lock again; return False after the timeout."""
        mine: list[bool] = []
        self._waiters.append(mine)
        count, self._count, self._owner = self._count, 0, None
        told = self._now().wait(lambda: mine, timeout)
        if not told:
            self._waiters = [waiter for waiter in self._waiters if waiter is not mine]
        self.acquire()
        self._count = count
        return told

    def notify(self, number: int = 1) -> None:
        """Tell some of those that wait."""
        for waiter in self._waiters[:number]:
            waiter.append(True)
        del self._waiters[:number]

    def notify_all(self) -> None:
        """Tell all that wait."""
        self.notify(len(self._waiters))


class Event:
    """As threading.Event."""

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        self._now = now
        self._is_set = False

    def is_set(self) -> bool:
        """Return whether it is set."""
        return self._is_set

    def set(self) -> None:
        """Set it."""
        self._is_set = True
        self._now().point()

    def clear(self) -> None:
        """Unset it."""
        self._is_set = False

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is set."""
        return self._now().wait(lambda: self._is_set, timeout)


class SimpleQueue:
    """As queue.SimpleQueue."""

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        self._now = now
        self._items: deque[Any] = deque()

    def put(self, item: Any) -> None:
        """Add an item."""
        self._items.append(item)
        self._now().point()

    def get(self) -> Any:
        """Wait for an item, and take it."""
        while not self._items:
            self._now().wait(lambda: self._items)
        return self._items.popleft()

    def get_nowait(self) -> Any:
        """Take an item; raise Empty if there is none."""
        if not self._items:
            raise queue.Empty
        return self._items.popleft()


class Thread:
    """As threading.Thread.

    Attributes:
        task: the task of the scheduler, once it is started.
    """

    current: Callable[[], Scheduler]  # set by subclasses
    table: Callable[[], dict[object, Any]]

    def __init__(
        self,
        group: None = None,
        target: Callable[..., object] | None = None,
        name: str | None = None,
        args: Iterable[Any] = (),
        kwargs: Mapping[str, Any] | None = None,
        *,
        daemon: bool | None = None,
    ) -> None:
        self.name = name or "thread"
        self.daemon = bool(daemon)
        self.ident: int | None = None
        self._target, self._args, self._kwargs = target, tuple(args), dict(kwargs or {})
        self.task: Any = None

    def start(self) -> None:
        """Start it."""
        if self.task is not None:
            raise RuntimeError("threads can only be started once")
        scheduler = type(self).current()
        self.task = scheduler.start(self.name, self.run)
        type(self).table()[self.task] = self
        self.ident = self.task.thread.ident
        scheduler.point()

    def run(self) -> None:
        """Do what it was made for."""
        if self._target is not None:
            self._target(*self._args, **self._kwargs)

    def is_alive(self) -> bool:
        """Return whether it runs."""
        return self.task is not None and not self.task.ended

    def join(self, timeout: float | None = None) -> None:
        """Wait for its end."""
        if self.task is None:
            raise RuntimeError("cannot join thread before it is started")
        if self.task is type(self).current().current:
            raise RuntimeError("cannot join current thread")
        type(self).current().wait(lambda: self.task.ended, timeout)


class Threading:
    """As the module threading.

    Args:
        now: returns the scheduler of the present run.
    """

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        self._now = now
        self._table: dict[object, Any] = {}

        class OurThread(Thread):
            current = staticmethod(now)
            table = staticmethod(lambda: self._table)

        self.Thread = OurThread

    def forget(self) -> None:
        """Begin a new run."""
        self._table.clear()

    def Lock(self) -> Lock:
        """Return a lock."""
        return Lock(self._now)

    def RLock(self) -> RLock:
        """Return a lock that its owner can take again."""
        return RLock(self._now)

    def Condition(self) -> Condition:
        """Return a condition."""
        return Condition(self._now)

    def Event(self) -> Event:
        """Return an event."""
        return Event(self._now)

    def current_thread(self) -> Any:
        """Return the thread that calls."""
        task = self._now().current
        if task not in self._table:  # the first one
            thread = self._table[task] = self.Thread(name="main")
            thread.task = task
            thread.ident = threading.get_ident()
        return self._table[task]

    def main_thread(self) -> Any:
        """Return the thread of the first task."""
        task = self._now().tasks[0]
        return self._table.get(task, self)

    def enumerate(self) -> list[Any]:
        """Return the threads that run."""
        return [thread for thread in self._table.values() if thread.is_alive()]

    def __getattr__(self, name: str) -> Any:
        return getattr(threading, name)


class Queues:
    """As the module queue.

    Args:
        now: returns the scheduler of the present run.
    """

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        self._now = now

    def SimpleQueue(self) -> SimpleQueue:
        """Return a queue."""
        return SimpleQueue(self._now)

    def __getattr__(self, name: str) -> Any:
        return getattr(queue, name)


class Time:
    """As the module time.

    Args:
        now: returns the scheduler of the present run.
    """

    def __init__(self, now: Callable[[], Scheduler]) -> None:
        self._now = now

    def monotonic(self) -> float:
        """Return the run's time."""
        scheduler = self._now()
        scheduler.now += 1e-7  # so that a loop that only looks at the clock ends
        return scheduler.now

    perf_counter = monotonic

    def time(self) -> float:
        """Return a wall time that goes with the run's time."""
        return WALL + self.monotonic()

    def time_ns(self) -> int:
        """Return the same in nanoseconds."""
        return round(self.time() * 1e9)

    def sleep(self, seconds: float) -> None:
        """Sleep by the run's clock."""
        self._now().pause(seconds)

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)
