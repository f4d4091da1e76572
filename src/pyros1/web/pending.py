"""What a client has begun and what comes next has to wait for. Safe for threads."""

from __future__ import annotations

import threading
from collections.abc import Callable

PATIENCE = 3.0
"""Seconds for which a client's next operation waits for its subscriptions: the master may be away."""


class Pending:
    """Things that are under way, such as subscriptions that the master does not know yet.

    Args:
        wake: called, from any thread, when nothing is under way any more.
    """

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._lock = threading.Lock()
        self._under_way: set[object] = set()

    def __bool__(self) -> bool:
        """Whether something is under way."""
        return bool(self._under_way)

    def begin(self) -> Callable[[], None]:
        """Note that something is under way; return what is to be called when it is done."""
        what = object()
        with self._lock:
            self._under_way.add(what)

        def done() -> None:
            with self._lock:
                self._under_way.discard(what)
                over = not self._under_way
            if over:
                self._wake()

        return done

    def give_up(self) -> None:
        """Wait no longer for what is under way now."""
        with self._lock:
            self._under_way.clear()
