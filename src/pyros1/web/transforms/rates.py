"""Rates of fast and slow topics, from arrivals or from the counts of nodes."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

SILENCE_TIMEOUT = 12.0
"""Seconds without messages, or with a single one, after which a topic counts as silent."""
_WINDOW = 5.0
"""Seconds over which a rate is measured; for slow topics, the interval of the newest two messages is used."""
_SAMPLE_MESSAGES = 30
"""Messages that suffice for a rate: for fast topics, only the newest ones count."""
_SILENCE_FACTOR = 3.0
"""Multiple of the usual interval after which a topic counts as stopped."""
_MAX_INTERVAL = 2.5
"""Seconds between checks beyond which the times of messages are unknown; longer if checks are rare."""
_MAX_TIMES = 10_000


class Rate(NamedTuple):
    """Messages and bytes per second."""

    hz: float
    bytes: float


NO_TRAFFIC = Rate(0.0, 0.0)


class Meter:
    """Measures what arrives.

    Args:
        now: the time at which it starts.
    """

    def __init__(self, now: float) -> None:
        self._lock = threading.Lock()
        self._started_at = now
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=_MAX_TIMES)

    def arrived(self, at: float, size: int) -> None:
        """Count a message."""
        with self._lock:
            self._arrivals.append((at, size))

    def rate(self, now: float) -> Rate | None:
        """Return the rate; None until it is known, which takes two messages."""
        with self._lock:
            times = list(self._arrivals)
        if not times or now - times[-1][0] > SILENCE_TIMEOUT:
            return NO_TRAFFIC if now - max(self._started_at, times[-1][0] if times else 0.0) > SILENCE_TIMEOUT else None
        recent = [each for each in times if each[0] > times[-1][0] - _WINDOW]
        recent = recent if len(recent) > 1 else times[-2:]
        seconds = recent[-1][0] - recent[0][0]
        if len(recent) < 2 or seconds <= 0 or seconds > SILENCE_TIMEOUT:
            return None
        hz = (len(recent) - 1) / seconds
        if now - recent[-1][0] > max(1.0, _SILENCE_FACTOR / hz):
            return NO_TRAFFIC
        return Rate(hz, hz * sum(size for _, size in recent) / len(recent))


class _Mark(NamedTuple):
    at: float
    messages: int
    bytes: int


class Track:
    """The counts of a node on one connection, check by check.

    Args:
        at: the time of the first check.
        messages: number of messages sent until then.
        size: their total bytes.
    """

    def __init__(self, at: float, messages: int, size: int) -> None:
        self._restart(at, messages, size)

    def _restart(self, at: float, messages: int, size: int) -> None:
        self._started_at = self._at = at
        self._interval = 0.0  # between the last two checks
        # The first one is the newest check before those with higher counts.
        self._marks = [_Mark(at, messages, size)]

    def update(self, at: float, messages: int, size: int) -> None:
        """Add the counts of another check."""
        newest = self._marks[-1]
        previous, self._interval = self._interval, at - self._at
        missed_times = self._interval > max(_MAX_INTERVAL, 1.5 * previous) and messages > newest.messages
        if messages < newest.messages or size < newest.bytes or missed_times:  # or the number was reused
            interval = self._interval
            self._restart(at, messages, size)
            self._interval = interval
            return
        self._at = at
        if messages > newest.messages:
            self._marks.append(_Mark(at, messages, size))
            while len(self._marks) > 3 and self._marks[1].at < at - SILENCE_TIMEOUT:
                del self._marks[0]
        elif len(self._marks) == 1:
            self._marks[0] = newest._replace(at=at)
        else:
            rate = self._measure()
            if at - newest.at > (_SILENCE_FACTOR / rate.hz if rate else SILENCE_TIMEOUT):
                self._marks = [newest._replace(at=at)]
                self._started_at = float("-inf")

    def rate(self) -> Rate | None:
        """Return the rate; None until it is known."""
        if len(self._marks) > 1:
            return self._measure()
        return NO_TRAFFIC if self._at - self._started_at > SILENCE_TIMEOUT else None

    def _measure(self) -> Rate | None:
        marks, newest = self._marks, self._marks[-1]
        start = next((mark for mark in marks[-2::-1] if newest.messages - mark.messages >= _SAMPLE_MESSAGES), marks[0])
        if start is marks[0] and len(marks) > 2:
            start = marks[1]  # the time of the first of them is known more precisely
        count, seconds = newest.messages - start.messages, newest.at - start.at
        if (start is marks[0] and count < 2) or seconds <= 0:
            return None
        return Rate(count / seconds, (newest.bytes - start.bytes) / seconds)
