"""Publishes a message repeatedly, in a thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic

from pyros1.ground.errors import Error


class RepeatedPublisher:
    """Calls a function at a given rate until it is closed. Calls that would be late are skipped.

    Args:
        publish: publishes a message, and returns the number of subscribers; called again even
            after it has raised `Error`.
        hz: calls per second; must be more than 0.

    Attributes:
        sent: number of successful calls.
        subscribers: the result of the last successful call.
        problem: why the last call failed; empty if it succeeded.
    """

    def __init__(self, publish: Callable[[], int], hz: float) -> None:
        self.publish = publish
        self.hz = hz
        self.sent = 0
        self.subscribers = 0
        self.problem = ""
        self._end_event = threading.Event()
        self._change_event = threading.Event()
        self._thread = threading.Thread(target=self._run, name="web: repeated publisher", daemon=True)
        self._thread.start()

    def change(self, publish: Callable[[], int], hz: float) -> None:
        """Continue at once with another function and rate."""
        self.publish, self.hz = publish, hz
        self._change_event.set()

    def close(self) -> None:
        """Stop after the current call, and wait up to 5 seconds for that call to end."""
        self._end_event.set()
        self._change_event.set()
        self._thread.join(5)

    def _run(self) -> None:
        next_time = monotonic()
        while not self._end_event.is_set():
            try:
                self.subscribers = self.publish()
                self.sent += 1
                self.problem = ""
            except Error as error:
                self.problem = str(error)
            next_time = max(next_time + 1 / self.hz, monotonic())
            if self._change_event.wait(max(0.0, next_time - monotonic())):
                self._change_event.clear()
                next_time = monotonic()
