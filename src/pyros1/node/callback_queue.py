"""The callback queue of a node that spins: holds callbacks until `spin` or `spin_once` runs them."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from pyros1.net.signal_safe import Condition


class CallbackQueue:
    """Queue of callables in order of arrival (https://wiki.ros.org/roscpp/Overview/Callbacks%20and%20Spinning)."""

    def __init__(self) -> None:
        self._callbacks: deque[Callable[[], object]] = deque()
        self._changed = Condition()
        self._spinning_thread_id: int | None = None  # the id of the thread that spun last

    def __len__(self) -> int:
        return len(self._callbacks)

    def push(self, callback: Callable[[], object]) -> None:
        """Add a callback. Thread-safe."""
        self._callbacks.append(callback)
        self._changed.notify_all()

    def wake(self) -> None:
        """Wake all waiting threads, whether or not callbacks are queued."""
        self._changed.notify_all()

    def is_callback_thread(self) -> bool:
        """Return whether the calling thread is the one that runs the callbacks.

        That is the thread that spun last, or the main thread if none has spun yet.
        """
        if self._spinning_thread_id is None:
            return threading.current_thread() is threading.main_thread()
        return self._spinning_thread_id == threading.get_ident()

    def wait(self, timeout: float) -> bool:
        """Wait for a callback, at most ``timeout`` seconds; return whether one is queued."""
        return self._changed.wait_for(lambda: self._callbacks, timeout)

    def run_available(self) -> int:
        """Run the callbacks that are currently queued, but not those added meanwhile; return how many were run."""
        self._spinning_thread_id = threading.get_ident()
        count = len(self._callbacks)
        for num_run in range(count):
            try:
                callback = self._callbacks.popleft()
            except IndexError:  # another thread that spins has taken the callback
                return num_run
            callback()
        return count
