"""Limits how many lines a board can log (no I/O)."""

from __future__ import annotations

BURST = 200
"""Lines that a board can log at once."""
RATE = 20.0
"""Lines per second that a board can log in the long run."""


class LogBudget:
    """Counts a board's log lines.

    Args:
        now: a monotonic time in seconds, as in the other methods.

    Attributes:
        num_dropped: how many lines were dropped since the last call of `take_dropped`.
    """

    def __init__(self, now: float) -> None:
        self.num_dropped = 0
        self._room, self._time = float(BURST), now

    def allows(self, now: float) -> bool:
        """Return whether a line may be logged. After a drop, none may until there is room for a second's worth."""
        self._room = min(BURST, self._room + (now - self._time) * RATE)
        self._time = now
        if self._room < (RATE if self.num_dropped else 1.0):
            self.num_dropped += 1
            return False
        self._room -= 1.0
        return True

    def take_dropped(self) -> int:
        """Return the number of dropped lines, and reset it to 0."""
        dropped, self.num_dropped = self.num_dropped, 0
        return dropped
