"""Rate limits for requests of other sites. No I/O."""

from __future__ import annotations


class TokenBucket:
    """A token bucket.

    Args:
        rate: allowed uses per second.
        burst: allowed uses at once, after a pause.
    """

    def __init__(self, rate: float, burst: float) -> None:
        self._rate = rate
        self._burst = burst
        self._left = float(burst)
        self._at = float("-inf")

    def take(self, now: float) -> bool:
        """Return whether a use is allowed now; if so, count it.

        Args:
            now: the current time in seconds.
        """
        self._left = min(self._burst, self._left + (now - self._at) * self._rate)
        self._at = now
        if self._left < 1:
            return False
        self._left -= 1
        return True

    def charge(self, amount: float) -> None:
        """Count further uses, so that `take` allows the next one only after some time."""
        self._left -= amount
