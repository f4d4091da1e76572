"""Callbacks in a thread of their own, which lives while there is something to call."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from pyros1.net.bell import Bell
from pyros1.node.log.logger import Log

_LINGERS = 0.5
"""Seconds for which the thread waits for more."""


class Calls:
    """Calls functions one after the other: those may wait for whatever other threads receive meanwhile.

    Args:
        name: the thread's name.
        log: for exceptions of such functions.
    """

    def __init__(self, name: str, log: Log) -> None:
        self._name = name
        self._log = log
        self._calls: deque[Callable[[], object]] = deque()
        self._lock = threading.RLock()
        self._bell = Bell()
        self._thread: threading.Thread | None = None

    def add(self, call: Callable[[], object]) -> None:
        """Call a function after all those before it."""
        with self._lock:
            self._calls.append(call)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()
        self._bell.ring()

    def _run(self) -> None:
        while True:
            self._bell.wait(lambda: self._calls, _LINGERS)
            with self._lock:
                if not self._calls:
                    self._thread = None
                    return
                call = self._calls.popleft()
            try:
                call()
            except Exception as error:  # noqa: BLE001 - of the program
                self._log.exception("error in a callback (%s)", self._name, error=error)
