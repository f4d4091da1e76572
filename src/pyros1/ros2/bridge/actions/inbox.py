"""The bounded queue of the thread that handles actions."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

MAX_TASKS = 10_000
MAX_BYTES = 64 << 20
"""Maximum total size in bytes of the waiting messages; a single larger one is accepted."""
Task = Callable[[], object]


class Inbox:
    """A bounded queue of tasks. May be used in several threads.

    Attributes:
        dropped: number of tasks refused because the queue was full.
    """

    def __init__(self, max_tasks: int = MAX_TASKS, max_bytes: int = MAX_BYTES) -> None:
        self.dropped = 0
        self._max_tasks = max_tasks
        self._max_bytes = max_bytes
        self._tasks: deque[tuple[Task, int]] = deque()
        self._bytes = 0
        self._is_closed = False
        self._changed = threading.Condition()

    def put(self, task: Task, size: int, *, is_due: bool = False) -> bool:
        """Add a task, and return whether there was room.

        Args:
            task: the task.
            size: how many bytes it holds.
            is_due: whether to accept it even if the queue is full; only for tasks of which there are never many.
        """
        with self._changed:
            is_full = len(self._tasks) >= self._max_tasks or self._bytes + size > self._max_bytes
            if self._is_closed or (is_full and self._tasks and not is_due):
                self.dropped += not self._is_closed
                return False
            self._tasks.append((task, size))
            self._bytes += size
            self._changed.notify()
            return True

    def get(self, timeout: float | None) -> Task | None:
        """Return the next task; None if there is none within `timeout` seconds, or after `close`."""
        with self._changed:
            self._changed.wait_for(lambda: self._tasks or self._is_closed, timeout)
            if not self._tasks or self._is_closed:
                return None
            task, size = self._tasks.popleft()
            self._bytes -= size
            return task

    def close(self) -> None:
        """Stop accepting tasks, and wake the waiting threads."""
        with self._changed:
            self._is_closed = True
            self._tasks.clear()
            self._changed.notify_all()
