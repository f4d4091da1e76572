"""Statistics of the messages of one publisher, for rosgraph_msgs/TopicStatistics
(https://wiki.ros.org/Topics#Topic_statistics). This module only computes: the caller passes times and sizes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple


class Limits(NamedTuple):
    """Limits on the number of messages in a window, and on its length in seconds."""

    min_messages: int = 10
    max_messages: int = 100
    min_seconds: float = 4
    max_seconds: float = 64


class Summary(NamedTuple):
    """Mean, standard deviation and maximum of a list of values; all are 0 if the list is empty."""

    mean: float
    deviation: float
    maximum: float


class Report(NamedTuple):
    """The messages received in a window.

    Attributes:
        start, stop: start and end of the window, in seconds.
        messages: number of messages received.
        lost: number of messages that are missing, according to the sequence numbers.
        size: total size of the messages in bytes.
        period: seconds between consecutive messages.
        age: seconds from a message's stamp to its arrival.
    """

    start: float
    stop: float
    messages: int
    lost: int
    size: int
    period: Summary
    age: Summary


def summarise(values: Sequence[float]) -> Summary:
    """Return the mean, standard deviation and maximum of the values."""
    if not values:
        return Summary(0.0, 0.0, 0.0)
    mean = math.fsum(values) / len(values)
    sum_of_squares = math.fsum((value - mean) ** 2 for value in values)
    return Summary(mean, math.sqrt(sum_of_squares / (len(values) - 1)) if len(values) > 1 else 0.0, max(values))


class Window:
    """The messages since the last report.

    Args:
        now: the current time in seconds.
        limits: the window's length, initially one second, is doubled or halved to stay within these limits.
    """

    def __init__(self, now: float, limits: Limits = Limits()) -> None:  # noqa: B008 - immutable
        self._limits = limits
        self._length = 1.0
        self._last_seq: int | None = None
        self._clear(now)

    def _clear(self, now: float) -> None:
        self._start = now
        self._arrivals: list[float] = []
        self._ages: list[float] = []
        self._lost = 0
        self._size = 0

    def add(self, now: float, size: int, seq: int | None = None, stamp: float | None = None) -> Report | None:
        """Record a message; return a report if the window is over.

        Args:
            now: the current time in seconds.
            size: size of the message in bytes.
            seq, stamp: sequence number, and stamp in seconds, from the message's header; None if it has no header.
        """
        self._arrivals.append(now)
        self._size += size
        if stamp is not None:
            self._ages.append(now - stamp)
        if seq is not None:
            if self._last_seq is not None and seq > self._last_seq + 1:
                self._lost += seq - self._last_seq - 1
            self._last_seq = seq
        if now - self._start < self._length:
            return None
        times = self._arrivals
        periods = [b - a for a, b in pairwise(times)]
        report = Report(self._start, now, len(times), self._lost, self._size, summarise(periods), summarise(self._ages))
        limits = self._limits
        if len(times) > limits.max_messages and self._length / 2 >= limits.min_seconds:
            self._length /= 2
        elif len(times) < limits.min_messages and self._length * 2 <= limits.max_seconds:
            self._length *= 2
        self._clear(now)
        return report
