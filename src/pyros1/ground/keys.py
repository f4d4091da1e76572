"""Reads keys from the terminal as soon as they are pressed."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import select
import signal
import sys
from typing import Any

from pyros1.ground.errors import Error

_PARTIAL_KEY = re.compile(r"\x1b[\[O]?\Z")
_ARROW_NAMES = {"A": "up", "B": "down", "C": "right", "D": "left"}


class NoTerminalError(Error):
    """Keys cannot be read; the error message says why."""


class KeyReader:
    """A context manager that reads keys from the terminal at standard input, and restores the terminal at the end.

    Keys are also read after the program was stopped (Ctrl-Z) and continued.

    Raises:
        NoTerminalError: on entering the context, if standard input is not a terminal, or this process runs in the
            background.
    """

    def __init__(self) -> None:
        self._descriptor = -1
        self._saved_attributes: Any = None
        self._saved_handler: Any = None
        self._partial_key = ""  # the first characters of an arrow key, whose other characters have not arrived yet

    def __enter__(self) -> KeyReader:
        try:
            import termios  # noqa: PLC0415 - not on Windows

            self._descriptor = sys.stdin.fileno()
            self._saved_attributes = termios.tcgetattr(self._descriptor)
        except (ImportError, ValueError, AttributeError, OSError, termios.error):
            raise NoTerminalError(
                "standard input is not a terminal: run this in a terminal of its own, without < or |"
            ) from None
        if not _is_in_foreground(self._descriptor):
            raise NoTerminalError("a program in the background cannot read keys: run this one without &")
        self._set_cbreak()
        with contextlib.suppress(ValueError):  # not in the main thread
            self._saved_handler = signal.signal(signal.SIGCONT, lambda *_: self._set_cbreak())
        return self

    def __exit__(self, *_: object) -> None:
        import termios  # noqa: PLC0415 - as above

        if self._saved_handler is not None:
            signal.signal(signal.SIGCONT, self._saved_handler)
        with contextlib.suppress(OSError, termios.error):  # the terminal has been closed
            if _is_in_foreground(self._descriptor):
                termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._saved_attributes)

    def _set_cbreak(self) -> None:
        import termios  # noqa: PLC0415 - as above
        import tty  # noqa: PLC0415 - as above

        with contextlib.suppress(OSError, termios.error):
            if _is_in_foreground(self._descriptor):
                tty.setcbreak(self._descriptor)

    def read(self, timeout: float) -> list[str] | None:
        """Wait for keys, and return their names, see `key_names`; return None if the terminal has been closed.

        Args:
            timeout: maximum number of seconds to wait; then, an empty list is returned.
        """
        with contextlib.suppress(OSError):
            ready, _, _ = select.select([self._descriptor], [], [], timeout)
            if not ready:
                return []
            if data := os.read(self._descriptor, 100):
                text = self._partial_key + data.decode("latin-1")
                complete_keys = _PARTIAL_KEY.sub("", text)
                self._partial_key = text[len(complete_keys) :]
                return key_names(complete_keys)
        return None


def key_names(text: str) -> list[str]:
    """Return the names of the keys in a terminal's input: up, down, left and right, or the key's character."""
    names = []
    characters = iter(text)
    for character in characters:
        if character == "\x1b" and next(characters, "") in ("[", "O"):
            names.append(_ARROW_NAMES.get(next(characters, ""), ""))
        else:
            names.append(character)
    return [name for name in names if name]


def _is_in_foreground(descriptor: int) -> bool:
    """Return whether this process receives keys: whether it is in the foreground, or not subject to job control."""
    try:
        return os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError as error:
        return error.errno == errno.ENOTTY  # no job control, as for the nodes of a launch, which have their own session
