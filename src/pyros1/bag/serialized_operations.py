"""Runs operations on a bag one at a time; any thread or signal handler can request them."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any


class SerializedOperations:
    """Serializes operations on a bag.

    Other threads wait until the running operation has finished. A signal handler that has interrupted an operation
    cannot wait for it: the operation that the handler requests runs as soon as the interrupted one has finished. This
    allows a program to close its bag when a signal ends its node.

    Attributes:
        lock: held by the thread that runs an operation.
        is_busy: whether an operation is running.
    """

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.is_busy = False
        self._postponed: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()

    def run(self, action: Callable[..., object], *args: Any) -> None:
        """Call a function now or, in a signal handler that has interrupted an operation, after that operation."""
        with self.lock:
            if self.is_busy:
                self._postponed.append((action, args))
                return
            self._run_postponed()
            try:
                self.is_busy = True
                action(*args)
            finally:
                self.is_busy = False
            self._run_postponed()

    def _run_postponed(self) -> None:
        """Run the postponed operations in order, even if a signal handler runs between any two of these lines."""
        while self._postponed:
            try:
                self.is_busy = True
                if self._postponed:
                    action, args = self._postponed.popleft()
                    action(*args)
            finally:
                self.is_busy = False
