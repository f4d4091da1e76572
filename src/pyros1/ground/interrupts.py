"""SIGINT and SIGTERM: how they end a program, and when a second one counts."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

TERMINATION_SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""The signals that ask a program to end."""
MIN_REPEAT_INTERVAL = 0.5
"""Seconds after which another signal counts as deliberate: ``timeout -s INT`` sends two at once, to a process
and to its group, and so do shells and launchers that pass Ctrl-C on to processes that already have it."""


class InterruptCounter:
    """Count of deliberate signals. Takes no locks, so signal handlers may use it.

    Args:
        clock: seconds.

    Attributes:
        count: signals that counted: the first, and each that comes `MIN_REPEAT_INTERVAL` seconds or more after the last
            of these.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last = 0.0
        self.count = 0

    def count_signal(self) -> bool:
        """Take note of a signal and return whether it counts."""
        now = self._clock()
        if self.count and now - self._last < MIN_REPEAT_INTERVAL:
            return False
        self._last = now
        self.count += 1
        return True


EXIT_INTERRUPTED = 128 + signal.SIGINT
"""Exit code of a process that SIGINT has ended, as shells report it."""


class Interrupt:
    """Handler of SIGINT that raises KeyboardInterrupt once; a second deliberate SIGINT ends the process at once."""

    def __init__(self) -> None:
        self._interrupts = InterruptCounter()

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if not self._interrupts.count_signal():
            return
        if self._interrupts.count > 1:
            die_by_signal(number)
        raise KeyboardInterrupt

    def resend(self) -> None:
        """Raise another KeyboardInterrupt in a moment, since the interpreter has swallowed the first."""
        self._interrupts = InterruptCounter()
        _thread.start_new_thread(_send_delayed, (signal.SIGINT,))


def _send_delayed(number: int) -> None:
    time.sleep(0.01)
    os.kill(os.getpid(), number)


def is_default_handler(handler: object) -> bool:
    """Return whether a signal handler is one of Python's or the system's own, and may be replaced."""
    return handler in (signal.SIG_DFL, signal.default_int_handler) or isinstance(handler, Interrupt)


@contextmanager
def keyboard_interrupts() -> Iterator[None]:
    """Let SIGINT raise KeyboardInterrupt in a ``with`` block if it would end the process at once, so that everything
    is cleaned up.

    Where an exception cannot propagate, such as in the callback of a weak reference during an import, the interpreter
    prints and drops it; another one is then raised in its place.
    """
    if signal.getsignal(signal.SIGINT) is not signal.SIG_DFL:
        yield
        return
    show = sys.unraisablehook

    def ignored(what: sys.UnraisableHookArgs) -> None:
        current = signal.getsignal(signal.SIGINT)
        if what.exc_type is KeyboardInterrupt and isinstance(current, Interrupt):
            current.resend()
        else:
            show(what)

    signal.signal(signal.SIGINT, Interrupt())
    sys.unraisablehook = ignored
    try:
        yield
    finally:
        sys.unraisablehook = show
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def die_by_signal(number: int = signal.SIGINT) -> NoReturn:
    """End the process by a signal, as if it had no handler."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
    raise SystemExit(128 + number)  # in case it is blocked


def install_handler(
    handler: Callable[[int, FrameType | None], object], numbers: Iterable[int] = TERMINATION_SIGNALS
) -> Callable[[], None]:
    """Install a handler of signals, in the main thread, and unblock the signals.

    A shell without job control starts what runs in the background with SIGINT ignored or, as fish, blocked. The nodes
    that this process starts would inherit that state.

    Args:
        handler: called with the signal's number and the frame that was interrupted.
        numbers: the signals' numbers.

    Returns:
        A function that restores the former handlers.
    """
    old = {number: signal.signal(number, handler) for number in numbers}
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, old)

    def restore() -> None:
        for number, former in old.items():
            signal.signal(number, signal.SIG_DFL if former is None else former)

    return restore
