"""Handlers of SIGINT and SIGTERM: the first ends the node, a second interrupts the program wherever it is.

Signals that follow too closely to be deliberate count as one, see `InterruptCounter`.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

from pyros1.ground.interrupts import InterruptCounter, install_handler, is_default_handler


class SignalHandlers:
    """Handlers that are installed for a node's lifetime.

    Args:
        on_signal: called with the signal's number at the first signal, in the handler, after the previous handler:
            it must not wait for anything.
    """

    def __init__(self, on_signal: Callable[[int], None]) -> None:
        self._on_signal = on_signal
        self._previous: dict[int, Any] = {}
        self._interrupts = InterruptCounter()
        self._restored = False

    @property
    def count(self) -> int:
        """The number of signals so far; those that came together count as one."""
        return self._interrupts.count

    def install(self) -> None:
        """Install the handlers; do nothing outside the main thread, where Python does not allow it."""
        if threading.current_thread() is not threading.main_thread():
            return
        numbers = (signal.SIGINT, signal.SIGTERM)
        self._previous = {number: signal.getsignal(number) for number in numbers}
        install_handler(self._handle, numbers)

    def restore(self) -> None:
        """Restore the previous handlers, unless other ones have been installed meanwhile."""
        if threading.current_thread() is not threading.main_thread():
            return
        if self.count:
            self._restored = (
                True  # the handlers stay: another signal may follow the first at once, and would cut the shutdown short
            )
            return
        for number, previous in self._previous.items():
            if signal.getsignal(number) == self._handle:
                signal.signal(number, previous)
        self._previous.clear()

    def _handle(self, number: int, frame: FrameType | None) -> None:
        counts = self._interrupts.count_signal()
        previous = self._previous.get(number)
        if self._restored:
            if counts:
                signal.signal(number, signal.SIG_DFL if previous is None else previous)
                os.kill(os.getpid(), number)
            return
        first = counts and self.count == 1
        if callable(previous) and not self._is_default(previous):
            try:
                previous(number, frame)  # first: it may want to publish
            finally:
                if first:
                    self._on_signal(number)
        elif first:
            self._on_signal(number)
        elif counts:
            self._interrupt(number)

    def _is_default(self, handler: Any) -> bool:
        """Return whether that handler is a default one, which ours replaces."""
        return is_default_handler(handler)

    def _interrupt(self, number: int) -> None:
        if number == signal.SIGTERM:
            raise SystemExit(128 + number)
        raise KeyboardInterrupt
