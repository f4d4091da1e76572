"""Waits that a signal handler can end: Python's Condition and Event hold a lock while they are set or waited for,
and a handler that interrupts its thread just then would wait for that lock forever.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from math import inf
from time import monotonic

POLL_INTERVAL = 0.2
"""Maximum seconds for which a signal may go unnoticed."""


class Condition:
    """A condition variable that a signal handler may notify: `notify_all` takes no lock."""

    def __init__(self) -> None:
        self._waiters: dict[threading.Lock, None] = {}  # locks whose release ends a wait

    def notify_all(self) -> None:
        """End all waits. Call it after a change of what they wait for."""
        for waiter in list(self._waiters):
            with contextlib.suppress(RuntimeError):  # if another call released it, and the wait has not removed it yet
                waiter.release()

    def wait_for(self, predicate: Callable[[], object], timeout: float | None = None) -> bool:
        """Wait until a predicate is true, or until the next `notify_all`.

        Args:
            predicate: the predicate; it is called before and after the wait.
            timeout: maximum seconds to wait; None for no limit.

        Returns:
            Whether the predicate is true.
        """
        waiter = threading.Lock()
        waiter.acquire()
        self._waiters[waiter] = None  # before the check, or a change in between would be missed
        try:
            if predicate():
                return True
            _acquire(waiter, timeout)
        finally:
            del self._waiters[waiter]
        return bool(predicate())


def _acquire(waiter: threading.Lock, timeout: float | None) -> None:
    """Wait for a lock, in steps.

    A signal that comes just before the interpreter begins to wait does not end that wait: its handler runs after it.
    """
    deadline = inf if timeout is None else monotonic() + timeout
    while (remaining := deadline - monotonic()) > 0 and not waiter.acquire(timeout=min(remaining, POLL_INTERVAL)):
        pass


class Event(threading.Event):
    """A threading.Event that a signal handler may set and wait for."""

    def __init__(self) -> None:
        super().__init__()
        self._is_set = False
        self._condition = Condition()

    def is_set(self) -> bool:
        """Return whether it is set."""
        return self._is_set

    def set(self) -> None:
        """Set it, which ends all waits."""
        self._is_set = True
        self._condition.notify_all()

    def clear(self) -> None:
        """Let later waits wait again."""
        self._is_set = False

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is set, at most ``timeout`` seconds; return whether it is."""
        return self._is_set or self._condition.wait_for(self.is_set, timeout)
