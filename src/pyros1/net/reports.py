"""What a loop has to say on stderr when nobody else wants to hear of its errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pyros1 import shown
from pyros1.net.background import Background, write_to_terminal
from pyros1.net.repeats import Repeats

if TYPE_CHECKING:
    from pyros1.net.loop import Loop


class ErrorReports:
    """Writes to stderr without waiting for it, and counts what repeats.

    Args:
        loop: who reports.
    """

    def __init__(self, loop: Loop) -> None:
        self._repeats = Repeats(loop.call_later)
        self._thread = Background(f"{loop.name}:errors", write_to_terminal)

    def say(self, text: str) -> None:
        """Write a text of one or more lines."""
        self._repeats.say("", shown.lines(text), lambda line: self._thread.write("stderr", line + "\n"))

    def close(self) -> None:
        """Write what is left, for at most a second."""
        self._repeats.close()
        self._thread.close()
