"""One operation on a bag at a time, whichever threads and signal handlers ask for them."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any


class Serialized:
    """Lets operations on a bag take turns.

    Those of other threads wait. One that a signal handler asks for on top of an operation of its own thread cannot wait
    for that, and the bag is in the middle of something: it is done as soon as the interrupted one has ended. So a
    program may close its bag when a signal ends its node.

    Attributes:
        lock: held by the thread whose turn it is.
        busy: whether that thread is in the middle of an operation.
    """

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.busy = False
        self._later: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()

    def do(self, action: Callable[..., object], *args: Any) -> None:
        """Call a function, now or when the operation below this one has ended."""
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
        """Do what was asked for meanwhile, in order, even if a signal handler comes between any two of these lines."""
        while self._later:
            try:
                self.busy = True
                if self._later:
                    action, args = self._later.popleft()
                    action(*args)
            finally:
                self.busy = False
