"""Signals with which a user, a shell or a service manager ends a program, and when a second one counts."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterable
from types import FrameType

ENDINGS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""The signals that ask a program to end."""
DELIBERATE = 0.5
"""Seconds from one signal to the next that a person may have meant: ``timeout -s INT`` sends two at once, to a process
and to its group, and so do shells and launchers that pass Ctrl-C on to who has got it already."""


class Insistence:
    """Counts how often a person has asked for the end. Takes no locks: for signal handlers.

    Args:
        clock: seconds.

    Attributes:
        count: times that counted: the first, and each that comes `DELIBERATE` seconds or more after the last of these.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last = 0.0
        self.count = 0

    def again(self) -> bool:
        """A signal came; return whether it counts."""
        now = self._clock()
        if self.count and now - self._last < DELIBERATE:
            return False
        self._last = now
        self.count += 1
        return True


def catch(handler: Callable[[int, FrameType | None], object], numbers: Iterable[int] = ENDINGS) -> Callable[[], None]:
    """Let signals call a handler, in the main thread, and let them come.

    A shell without job control starts what runs in the background with SIGINT ignored or, as fish, blocked. The nodes
    that this process starts would inherit that.

    Args:
        handler: called with the signal's number and the frame that was interrupted.
        numbers: of the signals.

    Returns:
        A function that puts the former handlers back.
    """
    old = {number: signal.signal(number, handler) for number in numbers}
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, old)

    def restore() -> None:
        for number, former in old.items():
            signal.signal(number, signal.SIG_DFL if former is None else former)

    return restore
