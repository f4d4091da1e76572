"""Handlers for SIGINT and SIGTERM that end a program, and a rule for when a repeated signal counts as deliberate."""

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
"""The signals that ask a program to terminate."""
MIN_REPEAT_INTERVAL = 0.5
"""Seconds after which another signal counts as deliberate. A process may receive two signals at once: ``timeout -s
INT`` sends one to the process and one to its group, and some shells and launchers pass on a Ctrl-C that the process has
already received."""


class InterruptCounter:
    """Counts deliberate signals. Acquires no locks, so signal handlers may use it.

    Args:
        clock: returns the current time in seconds.

    Attributes:
        count: number of deliberate signals: the first, and each that arrived at least `MIN_REPEAT_INTERVAL` seconds
            after the previous deliberate signal.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last_counted_at = 0.0
        self.count = 0

    def count_signal(self) -> bool:
        """Record a signal; return whether it counts as deliberate."""
        now = self._clock()
        if self.count and now - self._last_counted_at < MIN_REPEAT_INTERVAL:
            return False
        self._last_counted_at = now
        self.count += 1
        return True


INTERRUPTED_EXIT_CODE = 128 + signal.SIGINT
"""Exit code that shells report for a process killed by SIGINT."""


class InterruptHandler:
    """A handler that raises KeyboardInterrupt at the first SIGINT; a second deliberate SIGINT kills the process."""

    def __init__(self) -> None:
        self._interrupts = InterruptCounter()

    def __call__(self, signal_number: int, frame: FrameType | None) -> None:
        if not self._interrupts.count_signal():
            return
        if self._interrupts.count > 1:
            die_by_signal(signal_number)
        raise KeyboardInterrupt

    def resend(self) -> None:
        """Raise another KeyboardInterrupt after a moment, since the interpreter has dropped the first."""
        self._interrupts = InterruptCounter()
        _thread.start_new_thread(_send_delayed, (signal.SIGINT,))


def _send_delayed(signal_number: int) -> None:
    time.sleep(0.01)
    os.kill(os.getpid(), signal_number)


def is_default_handler(handler: object) -> bool:
    """Return whether a signal handler is a default handler (of Python, the system or pyros1), which may be replaced."""
    return handler in (signal.SIG_DFL, signal.default_int_handler) or isinstance(handler, InterruptHandler)


@contextmanager
def raise_keyboard_interrupts() -> Iterator[None]:
    """Let SIGINT raise KeyboardInterrupt in a ``with`` block if it would otherwise kill the process, so that the block
    can clean up.

    Where an exception cannot propagate, such as in the callback of a weak reference during an import, the interpreter
    prints and drops it; then another KeyboardInterrupt is raised a moment later.
    """
    if signal.getsignal(signal.SIGINT) is not signal.SIG_DFL:
        yield
        return
    previous_hook = sys.unraisablehook

    def hook(unraisable: sys.UnraisableHookArgs) -> None:
        handler = signal.getsignal(signal.SIGINT)
        if unraisable.exc_type is KeyboardInterrupt and isinstance(handler, InterruptHandler):
            handler.resend()
        else:
            previous_hook(unraisable)

    signal.signal(signal.SIGINT, InterruptHandler())
    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = previous_hook
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def is_keyboard_interrupt(error: BaseException) -> bool:
    """Return whether an exception is a KeyboardInterrupt or was caused by one.

    Before Python 3.12, a KeyboardInterrupt raised by ``__set_name__`` while a class is created becomes the cause of a
    RuntimeError.
    """
    return isinstance(error, KeyboardInterrupt) or isinstance(error.__cause__, KeyboardInterrupt)


def die_by_signal(signal_number: int = signal.SIGINT) -> NoReturn:
    """Kill this process with a signal, as if the signal had no handler."""
    signal.signal(signal_number, signal.SIG_DFL)
    os.kill(os.getpid(), signal_number)
    raise SystemExit(128 + signal_number)  # in case the signal is blocked


def install_handler(
    handler: Callable[[int, FrameType | None], object], signal_numbers: Iterable[int] = TERMINATION_SIGNALS
) -> Callable[[], None]:
    """Install a signal handler, and unblock the signals. Must be called in the main thread.

    Shells without job control start background processes with SIGINT ignored or, in the case of fish, blocked. The
    nodes that this process starts would inherit this state.

    Args:
        handler: called with the signal's number and the frame that was interrupted.
        signal_numbers: the signals' numbers.

    Returns:
        A function that restores the previous handlers.
    """
    previous_handlers = {signal_number: signal.signal(signal_number, handler) for signal_number in signal_numbers}
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, previous_handlers)

    def restore() -> None:
        for signal_number, previous_handler in previous_handlers.items():
            signal.signal(signal_number, signal.SIG_DFL if previous_handler is None else previous_handler)

    return restore
