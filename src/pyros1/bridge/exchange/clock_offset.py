"""The time by which another site's clock is ahead of ours, estimated from round trips of heartbeats. No I/O.

This estimates an upper bound of a message's age, not the most likely age, since messages that could be too old must not
be delivered. The answer to our heartbeat was sent after the heartbeat, whatever the delays in the two directions, which
bounds the offset. The smallest of several bounds is used; since clocks drift, a bound grows with time.

Clocks may also stop for a while, such as that of a paused virtual machine. The return path of a round trip bounds the
offset from below: if this lower bound exceeds the smallest upper bound, a clock has stopped since, and earlier bounds
no longer hold.
"""

from __future__ import annotations

import math
from collections import deque

_KEPT = 32
"""Number of bounds to keep."""
_KEPT_ROUND_TRIPS = 8
DRIFT = 1e-4
"""Maximum drift between two clocks, in seconds per second: a cheap quartz clock drifts half as much."""
_RESOLUTION = 1e-3
"""Seconds by which a round trip may be negative, since a clock may tick this coarsely."""
_MAX_ROUND_TRIP = 60.0
"""Round trips longer than this, in seconds, are ignored."""


class ClockOffset:
    """The offset of a site's clock. All times are in seconds.

    Attributes:
        round_trip: the last round trip; None before the first.
    """

    def __init__(self) -> None:
        self.round_trip: float | None = None
        self._round_trips: deque[float] = deque(maxlen=_KEPT_ROUND_TRIPS)
        self._latest: deque[float] = deque(maxlen=_KEPT)  # upper bounds of the offset, less the drift until then
        self._least = math.inf

    @property
    def is_known(self) -> bool:
        """Whether at least one bound of the offset is known."""
        return bool(self._latest)

    @property
    def shortest_round_trip(self) -> float:
        """The shortest of the last round trips; 0 if there were none."""
        return min(self._round_trips, default=0.0)

    def add(self, sent_at: float, received_at: float, their_time: float, reply_delay: float) -> None:
        """Add a round trip.

        Args:
            sent_at, received_at: when our heartbeat was sent and its answer arrived, by our clock.
            their_time: when the answer was sent, by their clock.
            reply_delay: the time between the arrival of our heartbeat and their answer, by their clock.
        """
        round_trip = received_at - sent_at - reply_delay
        if reply_delay < 0 or not -reply_delay * DRIFT - _RESOLUTION <= round_trip <= _MAX_ROUND_TRIP:
            return
        self.round_trip = max(0.0, round_trip)
        self._round_trips.append(self.round_trip)
        if their_time - received_at > self._least + received_at * DRIFT + _RESOLUTION:
            self._latest.clear()
        # The answer was sent after sent_at + reply_delay, by our clock, so their clock is ahead by this at most:
        self._latest.append(their_time - sent_at - reply_delay * (1 - DRIFT) - received_at * DRIFT)
        self._least = min(self._latest)

    def age(self, received_at: float, now: float) -> float | None:
        """Return the maximum possible age of a message.

        Args:
            received_at: when the other site received it, by their clock.
            now: the time by our clock.

        Returns:
            The age; None if the offset is not known; 0 if the message is dated in the future, which cannot be true.
        """
        return max(0.0, now - received_at + self._least + now * DRIFT) if self._latest else None
