"""Measures the rates of fast and slow topics, from arriving messages or from the counts that nodes report."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

SILENCE_TIMEOUT = 12.0
"""Seconds without messages, or with only one message, after which a topic is considered silent."""
_MEASUREMENT_PERIOD = 5.0
"""Seconds over which a rate is measured; for slow topics, the newest two messages are used, however far apart."""
_SUFFICIENT_MESSAGES = 30
"""Number of messages that suffice to measure a rate; for fast topics, older messages are not used."""
_SILENCE_FACTOR = 3.0
"""A topic is considered silent after this multiple of the usual interval between messages."""
_MAX_CHECK_INTERVAL = 2.5
"""If more than this many seconds have passed since the last check, it is unknown when messages were sent in between, so
the measurement starts again. This does not apply if checks are usually that rare.
"""
_MAX_ARRIVALS = 10_000


class Rate(NamedTuple):
    """Messages and bytes per second."""

    hz: float
    bytes: float


NO_TRAFFIC = Rate(0.0, 0.0)


class Meter:
    """Measures the rate of arriving messages.

    Args:
        now: the time at which the measurement starts.
    """

    def __init__(self, now: float) -> None:
        self._lock = threading.Lock()
        self._started_at = now
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=_MAX_ARRIVALS)

    def add(self, at: float, size: int) -> None:
        """Count a message; ``at`` is its time of arrival in seconds, ``size`` its size in bytes."""
        with self._lock:
            self._arrivals.append((at, size))

    def rate(self, now: float) -> Rate | None:
        """Return the current rate; None until it is known, which takes two messages."""
        with self._lock:
            arrivals = list(self._arrivals)
        if not arrivals or now - arrivals[-1][0] > SILENCE_TIMEOUT:
            return (
                NO_TRAFFIC
                if now - max(self._started_at, arrivals[-1][0] if arrivals else 0.0) > SILENCE_TIMEOUT
                else None
            )
        recent = [arrival for arrival in arrivals if arrival[0] > arrivals[-1][0] - _MEASUREMENT_PERIOD]
        recent = recent if len(recent) > 1 else arrivals[-2:]
        seconds = recent[-1][0] - recent[0][0]
        if len(recent) < 2 or seconds <= 0 or seconds > SILENCE_TIMEOUT:
            return None
        hz = (len(recent) - 1) / seconds
        if now - recent[-1][0] > max(1.0, _SILENCE_FACTOR / hz):
            return NO_TRAFFIC
        return Rate(hz, hz * sum(size for _, size in recent) / len(recent))


class _Sample(NamedTuple):
    at: float
    messages: int
    bytes: int


class CountMeter:
    """Measures the rate of messages on one connection from the counts that the sending node reports when it is polled.

    Args:
        at: the time of the first poll.
        messages: number of messages that were sent until then.
        size: the messages' total size in bytes.
    """

    def __init__(self, at: float, messages: int, size: int) -> None:
        self._restart(at, messages, size)

    def _restart(self, at: float, messages: int, size: int) -> None:
        self._started_at = self._checked_at = at
        self._interval = 0.0  # seconds between the last two checks
        # The first sample is from the last check before the count of messages increased.
        self._samples = [_Sample(at, messages, size)]

    def update(self, at: float, messages: int, size: int) -> None:
        """Process the counts that were reported at another check."""
        newest = self._samples[-1]
        previous, self._interval = self._interval, at - self._checked_at
        times_are_unknown = self._interval > max(_MAX_CHECK_INTERVAL, 1.5 * previous) and messages > newest.messages
        if messages < newest.messages or size < newest.bytes or times_are_unknown:  # smaller counts: the id was reused
            interval = self._interval
            self._restart(at, messages, size)
            self._interval = interval
            return
        self._checked_at = at
        if messages > newest.messages:
            self._samples.append(_Sample(at, messages, size))
            while len(self._samples) > 3 and self._samples[1].at < at - SILENCE_TIMEOUT:
                del self._samples[0]
        elif len(self._samples) == 1:
            self._samples[0] = newest._replace(at=at)
        else:
            rate = self._measure()
            if at - newest.at > (_SILENCE_FACTOR / rate.hz if rate else SILENCE_TIMEOUT):
                self._samples = [newest._replace(at=at)]
                self._started_at = float("-inf")

    def rate(self) -> Rate | None:
        """Return the current rate; None until it is known."""
        if len(self._samples) > 1:
            return self._measure()
        return NO_TRAFFIC if self._checked_at - self._started_at > SILENCE_TIMEOUT else None

    def _measure(self) -> Rate | None:
        samples, newest = self._samples, self._samples[-1]
        first = next(
            (sample for sample in samples[-2::-1] if newest.messages - sample.messages >= _SUFFICIENT_MESSAGES),
            samples[0],
        )
        if first is samples[0] and len(samples) > 2:
            first = samples[1]  # the time of this sample's last message is known more precisely
        count, seconds = newest.messages - first.messages, newest.at - first.at
        if (first is samples[0] and count < 2) or seconds <= 0:
            return None
        return Rate(count / seconds, (newest.bytes - first.bytes) / seconds)
