"""What a user may do to a bag that is played: pause, step, end it; from any thread, and from signal handlers."""

from __future__ import annotations

import contextlib
import os
import select
import threading
from collections.abc import Callable


class Control:
    """Wishes of the user.

    Args:
        paused: begin so.

    Attributes:
        paused: whether to play nothing.
        steps: messages to play though it is paused.
        pause_on_topics: whether to pause before messages of certain topics.
        ended: whether to end.
    """

    def __init__(self, paused: bool = False) -> None:
        self.paused = paused
        self.steps = 0
        self.pause_on_topics = True
        self.ended = False
        self._lock = threading.Lock()
        self._wake, self._bell = os.pipe()  # what a signal handler may use
        os.set_blocking(self._bell, False)
        os.set_blocking(self._wake, False)
        self._keys = -1
        self._on_key: Callable[[], object] = lambda: None

    def watch(self, descriptor: int, on_key: Callable[[], object]) -> None:
        """Call a function, from `wait`, when something can be read.

        Args:
            descriptor: where; -1 for nowhere.
            on_key: reads it.
        """
        self._keys, self._on_key = descriptor, on_key

    def set_paused(self, paused: bool) -> bool:
        """Pause, or go on; return False if that is so already."""
        with self._lock:
            changed, self.paused = self.paused != paused, paused
        self.ring()
        return changed

    def toggle(self) -> None:
        """Pause, or go on."""
        self.set_paused(not self.paused)

    def step(self) -> None:
        """Play one message, if paused."""
        if self.paused:
            self.steps += 1
            self.ring()

    def end(self) -> None:
        """End soon. Takes no lock."""
        self.ended = True
        self.ring()

    def ring(self) -> None:
        """End a wait."""
        with contextlib.suppress(OSError):  # it has been rung often enough, or all is over
            os.write(self._bell, b"!")

    def wait(self, seconds: float) -> None:
        """Wait; any change ends it early, and so does an hour.

        Args:
            seconds: 0 or less only looks for keys.
        """
        watched = [self._wake] if self._keys < 0 else [self._wake, self._keys]
        ready, _, _ = select.select(watched, [], [], min(max(0.0, seconds), 3600.0))
        if self._wake in ready:
            os.read(self._wake, 4096)
        if self._keys in ready:
            self._on_key()

    def close(self) -> None:
        """Let go of the system's resources."""
        wake, bell = self._wake, self._bell
        self._wake = self._bell = -1  # who rings later must not write into another file
        os.close(wake)
        os.close(bell)
