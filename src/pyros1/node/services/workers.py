"""A pool of threads for service calls: one per call in progress, up to a maximum number."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from time import monotonic

IDLE_TIMEOUT = 10.0
"""Seconds that a thread waits for a job before it exits."""


class Workers:
    """A pool of threads that run jobs.

    Args:
        name: prefix of the threads' names.
        max_threads: maximum number of threads.
    """

    def __init__(self, name: str, max_threads: int = 256) -> None:
        self._name = name
        self._max_threads = max_threads
        self._jobs: deque[Callable[[], None]] = deque()
        self._changed = threading.Condition()
        self._threads: set[threading.Thread] = set()
        self._num_idle = 0
        self._closed = False

    def submit(self, job: Callable[[], None]) -> bool:
        """Run a job soon; return False if all threads are busy and no more can be started, or the pool is closed."""
        with self._changed:
            if self._closed:
                return False
            if self._num_idle > len(self._jobs):
                self._jobs.append(job)
                self._changed.notify()
                return True
            if len(self._threads) >= self._max_threads:
                return False
            thread = threading.Thread(target=self._run, name=f"{self._name}-{len(self._threads)}", daemon=True)
            try:
                thread.start()  # with the lock held, so that `close` can join all threads that it finds
            except RuntimeError:  # the system allows no more threads
                return False
            self._jobs.append(job)
            self._threads.add(thread)
        return True

    def _run(self) -> None:
        while True:
            with self._changed:
                self._num_idle += 1
                while not self._jobs and not self._closed:
                    if not self._changed.wait(IDLE_TIMEOUT) and not self._jobs:
                        break
                self._num_idle -= 1
                if not self._jobs:
                    self._threads.discard(threading.current_thread())
                    return
                job = self._jobs.popleft()
            job()

    def close(self, timeout: float = 5.0) -> None:
        """Stop the threads after their current jobs; wait at most ``timeout`` seconds for all of them."""
        deadline = monotonic() + timeout
        with self._changed:
            self._closed = True
            self._jobs.clear()
            threads = list(self._threads)
            self._changed.notify_all()
        for thread in threads:
            if thread is not threading.current_thread():
                thread.join(max(0.0, deadline - monotonic()))
