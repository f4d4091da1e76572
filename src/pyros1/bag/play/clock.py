"""Bag time during playback, as a function of wall time. Does no I/O."""

from __future__ import annotations

NS_PER_S = 1_000_000_000
"""Nanoseconds per second."""


class Timeline:
    """Bag time, which runs `rate` times as fast as wall time unless it is paused.

    Args:
        rate: speed factor.

    Attributes:
        is_paused: whether bag time is paused.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._bag_origin = 0  # the bag time at self._wall_origin
        self._wall_origin = 0.0
        self.is_paused = False

    def set(self, bag_time: int, wall_time: float) -> None:
        """Set the bag time.

        Args:
            bag_time: bag time in nanoseconds.
            wall_time: current wall time in seconds.
        """
        self._bag_origin, self._wall_origin = bag_time, wall_time

    def bag_time_at(self, wall_time: float) -> int:
        """Return the bag time, in nanoseconds, at a wall time in seconds."""
        if self.is_paused:
            return self._bag_origin
        return self._bag_origin + round((wall_time - self._wall_origin) * self._rate * NS_PER_S)

    def wall_time_at(self, bag_time: int) -> float:
        """Return the wall time, in seconds, at which a bag time, in nanoseconds, is reached unless playback pauses."""
        return self._wall_origin + (bag_time - self._bag_origin) / (self._rate * NS_PER_S)

    def set_paused(self, wall_time: float, is_paused: bool) -> None:
        """Pause bag time, or let it continue, as of `wall_time` in seconds."""
        if is_paused != self.is_paused:
            bag_time = self.bag_time_at(wall_time)
            self.is_paused = is_paused
            self.set(bag_time, wall_time)


class Ticker:
    """Schedules regular ticks in wall time, for /clock or the status line on the terminal.

    Args:
        period: seconds between ticks.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.due_at = 0.0
        """Wall time of the next tick."""

    def tick(self, now: float) -> None:
        """Schedule the next tick, given the current wall time. A late tick does not delay later ticks, unless one was
        missed.
        """
        self.due_at += self._period
        if self.due_at <= now:
            self.due_at = now + self._period
