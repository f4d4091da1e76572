"""The statistics of ``topic hz``, ``bw`` and ``delay``, and their output (L64-L66)."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

HZ_WINDOW = 50_000
"""Default window of ``hz`` and ``delay`` in messages."""

BW_WINDOW = 100
"""Default window of ``bw`` in messages. It includes all messages of the last `BW_SECONDS` if there are more of them."""

BW_SECONDS = 1.0
"""Length of the default window of ``bw`` in seconds."""


class Summary(NamedTuple):
    """The statistics of the values in a window."""

    mean: float
    minimum: float
    maximum: float
    deviation: float


def summarise(values: Iterable[float]) -> Summary:
    """Return the mean, minimum, maximum and standard deviation of at least one value."""
    numbers = list(values)
    mean = sum(numbers) / len(numbers)
    deviation = math.sqrt(sum((number - mean) ** 2 for number in numbers) / len(numbers))
    return Summary(mean, min(numbers), max(numbers), deviation)


class RateMeter:
    """Measures the rate of a topic.

    Args:
        window: the maximum number of messages in the window; negative for `HZ_WINDOW`.
    """

    def __init__(self, window: int = -1) -> None:
        size = HZ_WINDOW if window < 0 else window
        self._intervals: deque[float] = deque(maxlen=max(1, size - 1))
        self._last: float | None = None
        self._has_new_message = False

    def add(self, now: float) -> None:
        """Add a message at the time ``now`` in seconds. If the time jumps back, the measurement is restarted."""
        previous, self._last = self._last, now
        if previous is None:
            return
        if now < previous:
            self._intervals.clear()
            return
        self._intervals.append(now - previous)
        self._has_new_message = True

    def measurement(self) -> tuple[float, Summary, int] | None:
        """Return the rate in Hz, the statistics of the intervals, and the number of messages in the window.

        Returns:
            These three values; None if no interval has ended since the last call.
        """
        intervals = list(self._intervals)  # a copy, since another thread may add to the deque
        if not self._has_new_message or not intervals:
            return None
        self._has_new_message = False
        summary = summarise(intervals)
        rate = 1.0 / summary.mean if summary.mean > 0 else 0.0
        return rate, summary, len(intervals) + 1


def rate_lines(rate: float, summary: Summary, message_count: int) -> str:
    """Return the output of ``hz`` for one topic."""
    return (
        f"average rate: {rate:.3f}\n\tmin: {summary.minimum:.3f}s max: {summary.maximum:.3f}s "
        f"std dev: {summary.deviation:.5f}s window: {message_count}"
    )


def rate_table(measurements: Mapping[str, tuple[float, Summary, int]]) -> str:
    """Return the output of ``hz`` for several topics."""
    header = ["topic", "rate", "min_delta", "max_delta", "std_dev", "window"]
    rows = [
        [
            topic,
            *(f"{value:.4}" for value in (rate, summary.minimum, summary.maximum, summary.deviation)),
            str(message_count),
        ]
        for topic, (rate, summary, message_count) in measurements.items()
    ]
    widths = [max(len(row[column]) for row in [header, *rows]) for column in range(len(header))]
    lines = ["   ".join(name.center(width) for name, width in zip(header, widths, strict=True))]
    lines.append("=" * len(lines[0]))
    lines += ["   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(lines) + "\n"


class BandwidthMeter:
    """Measures the bandwidth of a topic.

    Args:
        window: the size of the window in messages. If negative, the window contains the messages of the last second,
            but at least `BW_WINDOW` messages, which a fast topic may send in a single burst.
    """

    def __init__(self, window: int = -1) -> None:
        self._min_messages = BW_WINDOW if window < 0 else 0
        self._entries: deque[tuple[float, int]] = deque(maxlen=HZ_WINDOW if window < 0 else max(1, window))

    def add(self, now: float, size: int) -> None:
        """Add a message of ``size`` bytes at the time ``now`` in seconds."""
        entries = self._entries
        entries.append((now, size))
        while self._min_messages and len(entries) > self._min_messages and entries[0][0] < now - BW_SECONDS:
            entries.popleft()

    def lines(self, now: float) -> str | None:
        """Return the output of ``bw``; None if there are fewer than two messages."""
        entries = list(self._entries)
        if len(entries) < 2 or now <= entries[0][0]:
            return None
        return size_lines([size for _, size in entries], now - entries[0][0])


def size_lines(sizes: Sequence[int], seconds: float) -> str:
    """Return the output of ``bw`` for messages that arrived within a number of seconds, given their sizes in bytes."""
    rate = sum(sizes) / seconds
    unit, factor = ("B", 1) if rate < 1000 else ("KB", 1000) if rate < 1_000_000 else ("MB", 1_000_000)
    values = (rate, sum(sizes) / len(sizes), min(sizes), max(sizes))
    speed, mean, minimum, maximum = (f"{value / factor:.2f}{unit}" for value in values)
    return f"average: {speed}/s\n\tmean: {mean} min: {minimum} max: {maximum} window: {len(sizes)}"


class DelayMeter:
    """Measures the age of a topic's messages on arrival.

    Args:
        window: the maximum number of messages in the window; negative for `HZ_WINDOW`.
    """

    def __init__(self, window: int = -1) -> None:
        self._delays: deque[float] = deque(maxlen=HZ_WINDOW if window < 0 else max(1, window))
        self._has_new_message = False

    def add(self, delay: float) -> None:
        """Add a message that is ``delay`` seconds old on arrival."""
        self._delays.append(delay)
        self._has_new_message = True

    def lines(self) -> str | None:
        """Return the output of ``delay``; None if no message has arrived since the last call."""
        delays = list(self._delays)
        if not self._has_new_message:
            return None
        self._has_new_message = False
        return delay_lines(summarise(delays), len(delays))


def delay_lines(summary: Summary, message_count: int) -> str:
    """Return the output of ``delay``."""
    return (
        f"average delay: {summary.mean:.3f}\n\tmin: {summary.minimum:.3f}s max: {summary.maximum:.3f}s "
        f"std dev: {summary.deviation:.5f}s window: {message_count}"
    )
