"""Publishes repeatedly in a thread until it is closed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic

from pyros1.ground.errors import Error


class RepeatedPublisher:
    """Calls a function at a rate. Calls that would be too late are skipped.

    Args:
        publish: publishes, and returns the number of subscribers; it may raise `Error`, and is called again anyway.
        hz: calls per second, more than 0.

    Attributes:
        sent: number of successful calls.
        subscribers: the result of the last successful call.
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
        """Stop after the current call, and wait for it for up to 5 seconds."""
        self._ended.set()
        self._changed.set()
        self._thread.join(5)

    def _run(self) -> None:
        next_time = monotonic()
        while not self._ended.is_set():
            try:
                self.subscribers = self.publish()
                self.sent += 1
                self.problem = ""
            except Error as error:
                self.problem = str(error)
            next_time = max(next_time + 1 / self.hz, monotonic())
            if self._changed.wait(max(0.0, next_time - monotonic())):
                self._changed.clear()
                next_time = monotonic()
