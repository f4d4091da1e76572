"""How much flows: rates of fast and of slow topics, from arrivals or from what nodes have counted."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

SILENCE_TIMEOUT = 12.0
"""Seconds after which a topic of which nothing has come, or one message, counts as one without messages."""
_WINDOW = 5.0
"""Seconds over which a rate is measured; of slow topics, the time between the newest two messages."""
_SAMPLE_MESSAGES = 30
"""Messages that make a rate: of fast topics, the newest ones count alone."""
_SILENCE_FACTOR = 3.0
"""Times the usual distance of two messages, after which nothing flows any more."""
_MAX_INTERVAL = 2.5
"""Seconds between two looks after which the times of messages are not known; of looks that are far apart, more."""
_MAX_TIMES = 10_000


class Rate(NamedTuple):
    """Messages and bytes per second."""

    hz: float
    bytes: float


NO_TRAFFIC = Rate(0.0, 0.0)


class Meter:
    """Measures what arrives.

    Args:
        now: the time at which it begins.
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
        """Return the rate; None until it is known: two messages make a rate."""
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
    """What a node has counted on one connection, look by look.

    Args:
        at: the time of the first look.
        messages: how many were sent until then.
        size: bytes of all of them.
    """

    def __init__(self, at: float, messages: int, size: int) -> None:
        self._restart(at, messages, size)

    def _restart(self, at: float, messages: int, size: int) -> None:
        self._started_at = self._at = at
        self._interval = 0.0  # between the last two looks
        # The first one is the newest look before those at which there was more.
        self._marks = [_Mark(at, messages, size)]

    def update(self, at: float, messages: int, size: int) -> None:
        """Take the counts of another look."""
        newest = self._marks[-1]
        previous, self._interval = self._interval, at - self._at
        missed_times = self._interval > max(_MAX_INTERVAL, 1.5 * previous) and messages > newest.messages
        if messages < newest.messages or size < newest.bytes or missed_times:  # or another connection has its number
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
            start = marks[1]  # when the first of them came is known better
        count, seconds = newest.messages - start.messages, newest.at - start.at
        if (start is marks[0] and count < 2) or seconds <= 0:
            return None
        return Rate(count / seconds, (newest.bytes - start.bytes) / seconds)
