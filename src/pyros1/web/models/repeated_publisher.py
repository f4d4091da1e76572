"""Publishes repeatedly in a thread until it is closed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic

from pyros1.ground.errors import Error


class RepeatedPublisher:
    """Calls a function at a rate. Calls that would be too late are skipped.

    Args:
        publish: publishes, and returns the number of subscribers; after an `Error`, it is called again.
        hz: calls per second, more than 0.

    Attributes:
        sent: number of successful calls.
        subscribers: the result of the last call.
        problem: why the last call failed; empty if it did not.
    """

    def __init__(self, publish: Callable[[], int], hz: float) -> None:
        self.publish = publish
        self.hz = hz
        self.sent = 0
        self.subscribers = 0
        self.problem = ""
        self._ended = threading.Event()
        self._changed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="web: repeated publisher", daemon=True)
        self._thread.start()

    def change(self, publish: Callable[[], int], hz: float) -> None:
        """Continue with another function and rate, without delay."""
        self.publish, self.hz = publish, hz
        self._changed.set()

    def close(self) -> None:
        """Stop after the current call."""
        self._ended.set()
        self._changed.set()
        self._thread.join(5)

    def _run(self) -> None:
        due = monotonic()
        while not self._ended.is_set():
            try:
                self.subscribers = self.publish()
                self.sent += 1
                self.problem = ""
            except Error as error:
                self.problem = str(error)
            due = max(due + 1 / self.hz, monotonic())
            if self._changed.wait(max(0.0, due - monotonic())):
                self._changed.clear()
                due = monotonic()
