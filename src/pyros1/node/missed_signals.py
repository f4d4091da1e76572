"""Signals that the main thread does not notice.

Python runs signal handlers in the main thread, between two instructions. A signal that comes just before that thread
begins to wait, or that the system gives to another thread, wakes nobody: a program that waits in ``queue.get()`` would
never see its Ctrl-C. What the interpreter writes into its wakeup file lets the loop notice it and wake the main thread.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import weakref
from collections.abc import Callable

from pyros1.net.loop import READ, Loop

PATIENCE = 0.05
"""Seconds that a handler has to begin; then the main thread is woken, each time after twice as long."""
LONGEST_PATIENCE = 1.0


class MissedSignals:
    """Wakes the main thread for signals whose handler does not begin.

    Args:
        loop: looks after it.
        is_ours: whether a signal has the handler that calls `seen`; others are nobody's business here.
    """

    def __init__(self, loop: Loop, is_ours: Callable[[int], bool]) -> None:
        self._loop = loop
        self._is_ours = is_ours
        self._reading = self._writing = -1

    def watch(self) -> None:
        """Begin, in the main thread; not if a program has a wakeup file of its own, or the system cannot do it."""
        if not hasattr(signal, "pthread_kill"):
            return
        reading, writing = os.pipe()
        os.set_blocking(reading, False)
        os.set_blocking(writing, False)
        former = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
        if former != -1:
            signal.set_wakeup_fd(former)
            os.close(reading)
            os.close(writing)
            return
        self._reading, self._writing = reading, writing
        forget = weakref.WeakMethod(self._forget)
        os.register_at_fork(after_in_child=lambda: (method := forget()) and method())
        self._loop.call_soon(self._wait)

    def end(self) -> None:
        """End, in the main thread: nowhere else may the interpreter be told to write no more."""
        reading, writing = self._reading, self._writing
        if writing == -1:
            return
        self._forget()
        os.close(reading)
        os.close(writing)

    def seen(self) -> None:
        """A handler has begun."""
        self._take()

    def _forget(self) -> None:
        """Let the interpreter write no more; in a forked process, too, whose signals are not this one's."""
        writing, self._reading, self._writing = self._writing, -1, -1
        if writing != -1:
            with contextlib.suppress(ValueError):  # a fork by another thread than the main one, in an embedded Python
                former = signal.set_wakeup_fd(-1)
                if former not in (-1, writing):
                    signal.set_wakeup_fd(former)

    def _take(self) -> bytes:
        try:
            return os.read(self._reading, 4096)
        except OSError:  # nothing, or it has ended
            return b""

    def _wait(self) -> None:
        if self._reading != -1:
            self._loop.register(self._reading, READ, self._came)

    def _came(self, mask: int) -> None:
        self._loop.unregister(self._reading)
        self._loop.call_later(PATIENCE, self._look, PATIENCE)

    def _look(self, patience: float) -> None:
        missed = [number for number in set(self._take()) if self._is_ours(number)]
        if not missed:
            self._wait()
            return
        main = threading.main_thread().ident
        for number in missed:
            if main is not None:
                signal.pthread_kill(main, number)
        self._loop.call_later(patience, self._look, min(2 * patience, LONGEST_PATIENCE))
