"""Reports a loop's errors on stderr, if the loop has no other error handler."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pyros1.ground import terminal_text
from pyros1.net.background_writer import BackgroundWriter, write_to_terminal
from pyros1.net.rate_limit import RepeatCounter

if TYPE_CHECKING:
    from pyros1.net.loop import Loop


class ErrorReports:
    """Writes a loop's errors to stderr without blocking the loop, and counts repeated messages.

    Args:
        loop: the loop whose errors are reported.
    """

    def __init__(self, loop: Loop) -> None:
        self._repeats = RepeatCounter(loop.call_later)
        self._writer = BackgroundWriter(f"{loop.name}:errors", write_to_terminal)

    def log(self, text: str) -> None:
        """Write a message of one or more lines."""
        self._repeats.log("", terminal_text.lines(text), lambda line: self._writer.write("stderr", line + "\n"))

    def close(self) -> None:
        """Write the remaining messages, taking at most a second."""
        self._repeats.close()
        self._writer.close()
