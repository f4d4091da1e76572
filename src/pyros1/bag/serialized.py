"""Runs operations on a bag one at a time, for any threads and signal handlers."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any


class SerializedOperations:
    """Serializes operations on a bag.

    Operations of other threads wait. If a signal handler requests one while it interrupts another in its own thread, it
    cannot wait for that one, so the operation runs as soon as the interrupted one has finished. So a program can close
    its bag when a signal ends its node.

    Attributes:
        lock: held by the thread that runs an operation.
        busy: whether an operation is running.
    """

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.busy = False
        self._postponed: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()

    def run(self, action: Callable[..., object], *args: Any) -> None:
        """Call a function now, or when the interrupted operation has finished."""
        with self.lock:
            if self.busy:
                self._postponed.append((action, args))
                return
            self._run_postponed()
            try:
                self.busy = True
                action(*args)
            finally:
                self.busy = False
            self._run_postponed()

    def _run_postponed(self) -> None:
        """Run the postponed operations in order, even if a signal handler runs between any two of these lines."""
        while self._postponed:
            try:
                self.busy = True
                if self._postponed:
                    action, args = self._postponed.popleft()
                    action(*args)
            finally:
                self.busy = False
