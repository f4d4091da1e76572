"""Keys that control playback (B35)."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from typing import Any

from pyros1.bag.play.control import Control


class Keyboard:
    """Reads single keys from the terminal, if there is one. A context manager that restores the terminal on exit.

    When a stopped job is continued in the foreground, the terminal is set up again.

    Args:
        control: the playback control; space pauses or continues, ``s`` steps, ``t`` toggles pausing on topics.

    Attributes:
        is_available: whether there is a terminal.
    """

    def __init__(self, control: Control) -> None:
        self._control = control
        self._saved_attributes: Any = None
        self._saved_handler: Any = None
        self._descriptor = -1
        self.is_available = False

    def __enter__(self) -> Keyboard:
        try:
            import termios  # noqa: PLC0415 - not on Windows
        except ImportError:
            return self
        try:
            descriptor = sys.stdin.fileno()
            if not os.isatty(descriptor) or not _is_in_foreground(descriptor):
                return self
            self._saved_attributes = termios.tcgetattr(descriptor)
            self._descriptor, self.is_available = descriptor, True
            self._start_reading()
            self._saved_handler = signal.signal(signal.SIGCONT, lambda *_: self._start_reading())
        except (termios.error, OSError, ValueError, AttributeError):
            self.is_available = False
        return self

    def __exit__(self, *_: object) -> None:
        self._control.watch(-1, lambda: None)
        if self._saved_handler is not None:
            signal.signal(signal.SIGCONT, self._saved_handler)
        if self._saved_attributes is not None:
            import termios  # noqa: PLC0415

            with contextlib.suppress(OSError, termios.error):
                if _is_in_foreground(self._descriptor):
                    termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._saved_attributes)

    def _start_reading(self) -> None:
        """Start reading keys if this is a foreground job; the system stops background jobs that use the terminal."""
        import termios  # noqa: PLC0415
        import tty  # noqa: PLC0415

        self._control.watch(-1, lambda: None)
        with contextlib.suppress(OSError, termios.error):  # the terminal has been closed
            if _is_in_foreground(self._descriptor):
                tty.setcbreak(self._descriptor)
                self._control.watch(self._descriptor, self._read)

    def _read(self) -> None:
        try:
            keys = os.read(self._descriptor, 100)
        except OSError:
            keys = b""
        if not keys:  # the terminal has been closed
            self._control.watch(-1, lambda: None)
        for key in keys.decode("latin-1"):
            if key == " ":
                self._control.toggle()
            elif key == "s":
                self._control.step()
            elif key == "t":
                self._control.pause_on_topics = not self._control.pause_on_topics


def _is_in_foreground(descriptor: int) -> bool:
    return os.tcgetpgrp(descriptor) == os.getpgrp()
