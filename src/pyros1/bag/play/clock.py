"""Bag time while a bag is played, as a function of wall time. Pure."""

from __future__ import annotations

NS = 1_000_000_000


class Timeline:
    """Bag time, which runs `rate` times as fast as wall time unless it is stopped.

    Args:
        rate: factor of the speed.

    Attributes:
        is_held: whether bag time stands still.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._bag = 0  # the bag time at self._wall, from which it runs
        self._wall = 0.0
        self.is_held = False

    def set(self, bag: int, wall: float) -> None:
        """Set the bag time.

        Args:
            bag: bag time in nanoseconds.
            wall: present wall time in seconds.
        """
        self._bag, self._wall = bag, wall

    def bag_at(self, wall: float) -> int:
        """Return the bag time, in nanoseconds, at a wall time in seconds."""
        if self.is_held:
            return self._bag
        return self._bag + round((wall - self._wall) * self._rate * NS)

    def wall_at(self, bag: int) -> float:
        """Return the wall time, in seconds, of a bag time, assuming that bag time is not stopped."""
        return self._wall + (bag - self._bag) / (self._rate * NS)

    def set_held(self, wall: float, is_held: bool) -> None:
        """Stop bag time, or let it continue."""
        if is_held != self.is_held:
            bag = self.bag_at(wall)
            self.is_held = is_held
            self.set(bag, wall)


class Ticker:
    """Ticks in wall time, for /clock or a line on the terminal.

    Args:
        period: period in seconds.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.due = 0.0
        """Wall time of the next tick."""

    def tick(self, now: float) -> None:
        """Register a tick. Missed ticks are skipped; the rest keep the rhythm."""
        self.due += self._period
        if self.due <= now:
            self.due = now + self._period
