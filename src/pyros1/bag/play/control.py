"""Control of a bag that is played: pause, step, end; from any thread, and from signal handlers."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
from collections.abc import Callable


class Control:
    """Commands of the user.

    Args:
        paused: whether to begin paused.

    Attributes:
        paused: whether playing is paused.
        steps: number of messages to play while paused.
        pause_on_topics: whether to pause before messages of certain topics.
        ended: whether playing is to end.
    """

    def __init__(self, paused: bool = False) -> None:
        self.paused = paused
        self.steps = 0
        self.pause_on_topics = True
        self.ended = False
        self._lock = threading.Lock()
        self._wake_receiver, self._wake_sender = (
            socket.socketpair()
        )  # signal handlers may use sockets, and Windows can wait for them
        self._wake_sender.setblocking(False)
        self._wake_receiver.setblocking(False)
        self._keys = -1
        self._on_key: Callable[[], object] = lambda: None

    def watch(self, descriptor: int, on_key: Callable[[], object]) -> None:
        """Call a function, from `wait`, when a descriptor can be read.

        Args:
            descriptor: the descriptor; -1 for none.
            on_key: the function, which reads from it.
        """
        self._keys, self._on_key = descriptor, on_key

    def set_paused(self, paused: bool) -> bool:
        """Pause or continue; return False if that is already the state."""
        with self._lock:
            changed, self.paused = self.paused != paused, paused
        self.wake()
        return changed

    def toggle(self) -> None:
        """Pause if playing, else continue."""
        self.set_paused(not self.paused)

    def step(self) -> None:
        """Play one message, if paused."""
        if self.paused:
            self.steps += 1
            self.wake()

    def end(self) -> None:
        """Request the end of playing. Acquires no lock."""
        self.ended = True
        self.wake()

    def wake(self) -> None:
        """End a `wait`."""
        with contextlib.suppress(OSError):  # it is already full, or closed
            self._wake_sender.send(b"!")

    def wait(self, seconds: float) -> None:
        """Wait at most an hour; any change ends the wait early.

        Args:
            seconds: time to wait; with 0 or less, only keys are read.
        """
        descriptors: list[socket.socket | int] = (
            [self._wake_receiver] if self._keys < 0 else [self._wake_receiver, self._keys]
        )
        ready, _, _ = select.select(descriptors, [], [], min(max(0.0, seconds), 3600.0))
        if self._wake_receiver in ready:
            self._wake_receiver.recv(4096)
        if self._keys in ready:
            self._on_key()

    def close(self) -> None:
        """Close the sockets; later calls of `wake` do nothing."""
        self._wake_receiver.close()
        self._wake_sender.close()
