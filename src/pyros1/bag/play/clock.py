"""The time of a bag that is played, against the time on the wall. Pure."""

from __future__ import annotations

NS = 1_000_000_000


class Timeline:
    """Bag time flows `rate` times as fast as wall time, unless it is held.

    Args:
        rate: factor.

    Attributes:
        held: whether bag time stands still.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._bag = 0  # the bag time at self._wall, from where on it flows
        self._wall = 0.0
        self.held = False

    def set(self, bag: int, wall: float) -> None:
        """Say that it is now a bag time.

        Args:
            bag: in nanoseconds.
            wall: now, in seconds.
        """
        self._bag, self._wall = bag, wall

    def bag_at(self, wall: float) -> int:
        """Return the bag time, in nanoseconds, at a wall time in seconds."""
        if self.held:
            return self._bag
        return self._bag + round((wall - self._wall) * self._rate * NS)

    def wall_at(self, bag: int) -> float:
        """Return the wall time, in seconds, at which it will be a bag time, if nothing holds it."""
        return self._wall + (bag - self._bag) / (self._rate * NS)

    def hold(self, wall: float, held: bool) -> None:
        """Hold bag time, or let it go on from where it was held."""
        if held != self.held:
            bag = self.bag_at(wall)
            self.held = held
            self.set(bag, wall)


class Ticker:
    """Ticks in wall time: of /clock, of a line on the terminal.

    Args:
        period: in seconds.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.due = 0.0
        """Wall time of the next tick."""

    def tick(self, now: float) -> None:
        """Take note of a tick. Ticks that were missed are left out; the others stay in step."""
        self.due += self._period
        if self.due <= now:
            self.due = now + self._period
