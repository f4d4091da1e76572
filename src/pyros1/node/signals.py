"""SIGINT and SIGTERM: the first asks the node to end, a second interrupts the program wherever it is."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any


class SignalHandlers:
    """Handlers that are installed for a node's life.

    Args:
        on_signal: called with the signal's number at the first signal, in the handler, after the handler that was there
            before: it must not wait for anything.

    Attributes:
        count: signals so far.
    """

    def __init__(self, on_signal: Callable[[int], None]) -> None:
        self._on_signal = on_signal
        self._previous: dict[int, Any] = {}
        self.count = 0

    def install(self) -> None:
        """Install the handlers; nothing happens outside the main thread, where Python allows none."""
        if threading.current_thread() is not threading.main_thread():
            return
        for number in (signal.SIGINT, signal.SIGTERM):
            self._previous[number] = signal.signal(number, self._handle)

    def restore(self) -> None:
        """Put the former handlers back, unless somebody has put others in place of ours."""
        if threading.current_thread() is not threading.main_thread():
            return
        for number, previous in self._previous.items():
            if signal.getsignal(number) == self._handle:
                signal.signal(number, previous)
        self._previous.clear()

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.count += 1
        first = self.count == 1
        previous = self._previous.get(number)
        if callable(previous) and previous is not signal.default_int_handler:
            try:
                previous(number, frame)  # first: it may have something to publish
            finally:
                if first:
                    self._on_signal(number)
        elif first:
            self._on_signal(number)
        elif self.count > 1:
            if number == signal.SIGTERM:
                raise SystemExit(128 + number)
            raise KeyboardInterrupt
