"""Runs one operation on a bag at a time, for any threads and signal handlers."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any


class Serialized:
    """Serializes operations on a bag.

    Operations of other threads wait. If a signal handler requests one while its own thread is in the middle of another,
    it cannot wait for that: it is performed as soon as the interrupted operation has ended. So a program may close its
    bag when a signal ends its node.

    Attributes:
        lock: held by the thread whose turn it is.
        busy: whether that thread is in the middle of an operation.
    """

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.busy = False
        self._later: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()

    def do(self, action: Callable[..., object], *args: Any) -> None:
        """Call a function, now or when the interrupted operation has ended."""
        with self.lock:
            if self.busy:
                self._later.append((action, args))
                return
            self._catch_up()
            try:
                self.busy = True
                action(*args)
            finally:
                self.busy = False
            self._catch_up()

    def _catch_up(self) -> None:
        """Perform the postponed operations in order, even if a signal handler runs between any two of these lines."""
        while self._later:
            try:
                self.busy = True
                if self._later:
                    action, args = self._later.popleft()
                    action(*args)
            finally:
                self.busy = False
