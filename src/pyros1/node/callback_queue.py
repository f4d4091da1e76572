"""The callback queue of a node that spins: callbacks wait here for `spin` or `spin_once`."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from pyros1.net.signal_safe import Condition


class CallbackQueue:
    """Queue of callables in order of arrival (https://wiki.ros.org/roscpp/Overview/Callbacks%20and%20Spinning)."""

    def __init__(self) -> None:
        self._ready: deque[Callable[[], object]] = deque()
        self._changed = Condition()
        self._runner: int | None = None  # the thread that spins

    def __len__(self) -> int:
        return len(self._ready)

    def push(self, callback: Callable[[], object]) -> None:
        """Add a callback. Any thread."""
        self._ready.append(callback)
        self._changed.notify_all()

    def wake(self) -> None:
        """Wake all waiting threads, whether or not callbacks are queued."""
        self._changed.notify_all()

    def runs_here(self) -> bool:
        """Return whether the calling thread runs the callbacks: the thread that spun last, or else the main thread."""
        if self._runner is None:
            return threading.current_thread() is threading.main_thread()
        return self._runner == threading.get_ident()

    def wait(self, timeout: float) -> bool:
        """Wait for a callback, at most ``timeout`` seconds; return whether one is queued."""
        return self._changed.wait_for(lambda: self._ready, timeout)

    def run_available(self) -> int:
        """Run the callbacks that are queued now, not those that they add; return how many were run."""
        self._runner = threading.get_ident()
        count = len(self._ready)
        for done in range(count):
            try:
                callback = self._ready.popleft()
            except IndexError:  # another thread spins too
                return done
            callback()
        return count
