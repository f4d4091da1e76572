"""Condition and Event, for use by signal handlers as well. Python's own classes hold a lock while they are notified or
waited for: a signal handler that interrupts the thread at that moment would wait for the lock forever.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from math import inf
from time import monotonic

POLL_INTERVAL = 0.2
"""Maximum number of seconds by which a wait delays the handler of a signal."""


class Condition:
    """A condition variable that a signal handler may notify: `notify_all` takes no lock."""

    def __init__(self) -> None:
        self._waiters: dict[threading.Lock, None] = {}  # one locked lock for each wait; releasing it ends the wait

    def notify_all(self) -> None:
        """Wake all waiting threads. Call it after changing what they wait for."""
        for waiter in list(self._waiters):
            with contextlib.suppress(RuntimeError):  # another call has released the lock already
                waiter.release()

    def wait_for(self, predicate: Callable[[], object], timeout: float | None = None) -> bool:
        """Wait until the next `notify_all`, unless a predicate is true already.

        Args:
            predicate: called before and after the wait.
            timeout: maximum number of seconds to wait; None for no limit.

        Returns:
            Whether the predicate is true.
        """
        waiter = threading.Lock()
        waiter.acquire()
        self._waiters[waiter] = None  # before the check; otherwise a change in between would be missed
        try:
            if predicate():
                return True
            _acquire_in_steps(waiter, timeout)
        finally:
            del self._waiters[waiter]
        return bool(predicate())


def _acquire_in_steps(waiter: threading.Lock, timeout: float | None) -> None:
    """Wait for a lock, in short steps, at most ``timeout`` seconds.

    A signal that arrives just before the interpreter starts to wait does not interrupt that wait: its handler runs only
    after the wait.
    """
    deadline = inf if timeout is None else monotonic() + timeout
    while (remaining := deadline - monotonic()) > 0 and not waiter.acquire(timeout=min(remaining, POLL_INTERVAL)):
        pass


class Event(threading.Event):
    """A threading.Event that signal handlers may set and wait for."""

    def __init__(self) -> None:
        super().__init__()
        self._is_set = False
        self._condition = Condition()

    def is_set(self) -> bool:
        """Return whether the event is set."""
        return self._is_set

    def set(self) -> None:
        """Set the event and wake all waiting threads."""
        self._is_set = True
        self._condition.notify_all()

    def clear(self) -> None:
        """Reset the event, so that later waits block again."""
        self._is_set = False

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the event is set, at most ``timeout`` seconds; return whether it is set."""
        return self._is_set or self._condition.wait_for(self.is_set, timeout)
