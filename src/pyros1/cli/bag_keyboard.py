"""Keys that control a bag's playing (B35)."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import Any

from pyros1.bag.play_control import Control


class Keyboard:
    """Reads single keys from the terminal, if there is one. A context manager that puts the terminal back.

    Args:
        control: what the keys change: space pauses, ``s`` steps, ``t`` toggles pausing on topics.

    Attributes:
        there: whether there is a terminal.
    """

    def __init__(self, control: Control) -> None:
        self._control = control
        self._former: Any = None
        self._descriptor = -1
        self.there = False

    def __enter__(self) -> Keyboard:
        try:
            import termios  # noqa: PLC0415 - not on Windows
            import tty  # noqa: PLC0415

            descriptor = sys.stdin.fileno()
            # A job in the background must not touch the terminal: it would be stopped.
            if not os.isatty(descriptor) or os.tcgetpgrp(descriptor) != os.getpgrp():
                return self
            self._former = termios.tcgetattr(descriptor)
            tty.setcbreak(descriptor)
        except (ImportError, OSError, ValueError, AttributeError):
            return self
        self._descriptor, self.there = descriptor, True
        self._control.watch(descriptor, self._read)
        return self

    def __exit__(self, *_: object) -> None:
        self._control.watch(-1, lambda: None)
        if self._former is not None:
            import termios  # noqa: PLC0415

            with contextlib.suppress(OSError, termios.error):
                termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._former)

    def _read(self) -> None:
        try:
            keys = os.read(self._descriptor, 100)
        except OSError:
            keys = b""
        if not keys:  # the terminal has gone
            self._control.watch(-1, lambda: None)
        for key in keys.decode("latin-1"):
            if key == " ":
                self._control.toggle()
            elif key == "s":
                self._control.step()
            elif key == "t":
                self._control.pause_on_topics = not self._control.pause_on_topics
