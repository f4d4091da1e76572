"""The launcher's output for the user: plain and bold lines, errors and warnings, with colours on terminals (L16)."""

from __future__ import annotations

import contextlib
import sys
import threading
from typing import TextIO


class Console:
    """Writes whole lines without delay.

    Args:
        out: stream for ordinary lines; None for stdout.
        err: stream for errors and warnings; None for stderr.
        log: a file that also receives everything.
        title: whether `title` sets the terminal's title, if ``out`` is a terminal.
    """

    def __init__(
        self, out: TextIO | None = None, err: TextIO | None = None, *, log: TextIO | None = None, title: bool = True
    ) -> None:
        self._out = out or sys.stdout
        self._err = err or sys.stderr
        self._log = log
        self._sets_title = title
        self._lock = threading.Lock()

    def log_to(self, log: TextIO | None) -> None:
        """Write everything to `log` as well; None stops this."""
        self._log = log

    def line(self, text: str = "") -> None:
        """Write an ordinary line."""
        self._write(self._out, text, "")

    def bold(self, text: str) -> None:
        """Write a bold line."""
        self._write(self._out, text, "\033[1m")

    def plain_error(self, text: str) -> None:
        """Write a line to stderr, in red and without a prefix."""
        self._write(self._err, text, "\033[31m")

    def error(self, text: str) -> None:
        """Write an error."""
        self.plain_error(f"ERROR: {text}")

    def warning(self, text: str) -> None:
        """Write a warning."""
        self.plain_error(f"WARNING: {text}")

    def set_title(self, text: str) -> None:
        """Set the terminal's title."""
        if self._sets_title and self._out.isatty():
            with self._lock:
                # Not through a command's own stream, which escapes control characters.
                out = getattr(self._out, "underlying", self._out)
                out.write(f"\033]2;{text}\007")
                out.flush()

    def _write(self, stream: TextIO, text: str, style: str) -> None:
        with self._lock:
            try:
                stream.write(f"{style}{text}\033[0m\n" if style and stream.isatty() else text + "\n")
                stream.flush()
            except (OSError, ValueError):
                pass  # the stream is closed, or the disk is full; the nodes must still be supervised
            if self._log is not None:
                with contextlib.suppress(OSError, ValueError):
                    self._log.write(text + "\n")
                    self._log.flush()
