"""Handlers for SIGINT and SIGTERM: the first signal shuts down the node, a second one interrupts the program.

Signals in quick succession are counted as one, see `InterruptCounter`.
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
    """Handlers that are installed while a node exists.

    Args:
        on_signal: called with the number of the first signal, in the handler, after the previous handler. It must not
            block.
    """

    def __init__(self, on_signal: Callable[[int], None]) -> None:
        self._on_signal = on_signal
        self._previous_handlers: dict[int, Any] = {}
        self._interrupts = InterruptCounter()
        self._restores_on_next_signal = False

    @property
    def count(self) -> int:
        """The number of signals so far; those in quick succession are counted as one."""
        return self._interrupts.count

    def install(self) -> None:
        """Install the handlers; do nothing in threads other than the main one, where Python does not allow it."""
        if threading.current_thread() is not threading.main_thread():
            return
        numbers = (signal.SIGINT, signal.SIGTERM)
        self._previous_handlers = {number: signal.getsignal(number) for number in numbers}
        install_handler(self._handle, numbers)

    def restore(self) -> None:
        """Restore the previous handlers. If a signal has been received, this happens only when the next one arrives.

        Handlers that were installed later remain.
        """
        if threading.current_thread() is not threading.main_thread():
            return
        if self.count:
            # Keep the handlers for now: the second of two signals in quick succession must not abort the shutdown.
            self._restores_on_next_signal = True
            return
        for number, previous_handler in self._previous_handlers.items():
            if signal.getsignal(number) == self._handle:
                signal.signal(number, previous_handler)
        self._previous_handlers.clear()

    def _handle(self, number: int, frame: FrameType | None) -> None:
        is_counted = self._interrupts.count_signal()
        previous_handler = self._previous_handlers.get(number)
        if self._restores_on_next_signal:
            if is_counted:
                signal.signal(number, signal.SIG_DFL if previous_handler is None else previous_handler)
                os.kill(os.getpid(), number)
            return
        is_first = is_counted and self.count == 1
        if callable(previous_handler) and not self._is_default(previous_handler):
            try:
                previous_handler(number, frame)  # before the shutdown, since this handler may publish
            finally:
                if is_first:
                    self._on_signal(number)
        elif is_first:
            self._on_signal(number)
        elif is_counted:
            self._interrupt(number)

    def _is_default(self, handler: Any) -> bool:
        """Return whether a previous handler is one of Python's default handlers, which are not called."""
        return is_default_handler(handler)

    def _interrupt(self, number: int) -> None:
        if number == signal.SIGTERM:
            raise SystemExit(128 + number)
        raise KeyboardInterrupt
