"""Controls playback: pause, step and end, from any thread or signal handler."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
from collections.abc import Callable


class Control:
    """The state of playback that the user's commands change, and a way to wait for changes.

    Args:
        paused: whether to start paused.

    Attributes:
        is_paused: whether playback is paused.
        steps: number of messages still to play while paused.
        pause_on_topics: whether to pause before messages of certain topics.
        end_requested: whether playback should end.
    """

    def __init__(self, paused: bool = False) -> None:
        self.is_paused = paused
        self.steps = 0
        self.pause_on_topics = True
        self.end_requested = False
        self._lock = threading.Lock()
        # Unlike locks, sockets can be used in signal handlers; unlike pipes, select() supports them on Windows.
        self._wake_receiver, self._wake_sender = socket.socketpair()
        self._wake_sender.setblocking(False)
        self._wake_receiver.setblocking(False)
        self._key_descriptor = -1
        self._on_key: Callable[[], object] = lambda: None

    def watch(self, descriptor: int, on_key: Callable[[], object]) -> None:
        """Make `wait` call a function when a descriptor becomes readable.

        Args:
            descriptor: the file descriptor; -1 for none.
            on_key: the function, which must read from the descriptor.
        """
        self._key_descriptor, self._on_key = descriptor, on_key

    def set_paused(self, paused: bool) -> bool:
        """Pause or continue playback; return whether the state has changed. Thread-safe."""
        with self._lock:
            has_changed, self.is_paused = self.is_paused != paused, paused
        self.wake()
        return has_changed

    def toggle(self) -> None:
        """Pause playback, or continue if it is paused."""
        self.set_paused(not self.is_paused)

    def step(self) -> None:
        """Play one message if playback is paused."""
        if self.is_paused:
            self.steps += 1
            self.wake()

    def end(self) -> None:
        """Request the end of playback. Safe in signal handlers: acquires no lock."""
        self.end_requested = True
        self.wake()

    def wake(self) -> None:
        """Make `wait` return at once."""
        with contextlib.suppress(OSError):  # the socket buffer is full, or the socket is closed
            self._wake_sender.send(b"!")

    def wait(self, seconds: float) -> None:
        """Wait until the state changes or a key is pressed, at most an hour.

        Args:
            seconds: maximum time to wait; with 0 or less, only keys are read.
        """
        descriptors: list[socket.socket | int] = (
            [self._wake_receiver] if self._key_descriptor < 0 else [self._wake_receiver, self._key_descriptor]
        )
        ready, _, _ = select.select(descriptors, [], [], min(max(0.0, seconds), 3600.0))
        if self._wake_receiver in ready:
            self._wake_receiver.recv(4096)
        if self._key_descriptor in ready:
            self._on_key()

    def close(self) -> None:
        """Close the sockets; later calls to `wake` do nothing."""
        self._wake_receiver.close()
        self._wake_sender.close()
