"""Common tasks: checking how often something happens, checking time stamps, and combining several tasks.

A task is a function that fills in a `Status`.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence

from pyros1.diagnostics.status import ERROR, OK, WARN, Status
from pyros1.ground.timing import Time

Task = Callable[[Status], object]
"""A function that fills in a `Status`."""


def alive(status: Status) -> None:
    """Report that the node is alive. This function is a task."""
    status.summary(OK, "Alive")


class Frequency:
    """Counts events, and reports whether they occur as often as they should.

    Args:
        now: returns the time, for example ``node.now``.
        minimum, maximum: the limits in Hz; a ``maximum`` of None means no limit.
        tolerance: how far the frequency may lie outside the limits, as a fraction of them; 0.1 means 10 %.
        window: the number of most recent runs of the task over which events are counted.
    """

    def __init__(
        self,
        now: Callable[[], Time],
        minimum: float = 0.0,
        maximum: float | None = float("inf"),
        tolerance: float = 0.1,
        window: int = 5,
    ) -> None:
        self.minimum, self.maximum, self.tolerance = minimum, maximum, tolerance
        self._now = now
        self._window = window
        self._lock = threading.RLock()
        self.clear()

    def clear(self) -> None:
        """Forget all events, and restart the window."""
        with self._lock:
            self._count = 0
            self._runs = deque([(self._now(), 0)] * self._window, self._window)

    def tick(self) -> None:
        """Count an event."""
        with self._lock:
            self._count += 1

    def run(self, status: Status) -> None:
        """Fill in a status with the frequency over the last runs. Pass this method to the updater as the task."""
        with self._lock:
            now, count = self._now(), self._count
            window_start, count_before = self._runs[0]
            self._runs.append((now, count))
        events, seconds = count - count_before, (now - window_start).to_sec()
        frequency = events / seconds if seconds else 0.0
        lowest_acceptable = self.minimum * (1 - self.tolerance)
        highest_acceptable = None if self.maximum is None else self.maximum * (1 + self.tolerance)
        if not events:
            status.summary(ERROR, "No events recorded.")
        elif seconds and frequency < lowest_acceptable:
            status.summary(WARN, "Frequency too low.")
        elif highest_acceptable is not None and frequency > highest_acceptable:
            status.summary(WARN, "Frequency too high.")
        else:
            status.summary(OK, "Desired frequency met")
        status.add("Events in window", events)
        status.add("Events since startup", count)
        status.add("Duration of window (s)", f"{seconds:f}")
        status.add("Actual frequency (Hz)", f"{frequency:f}")
        if self.minimum == self.maximum:
            status.add("Target frequency (Hz)", f"{self.minimum:f}")
        if self.minimum > 0:
            status.add("Minimum acceptable frequency (Hz)", f"{lowest_acceptable:f}")
        if highest_acceptable is not None:
            status.add("Maximum acceptable frequency (Hz)", f"{highest_acceptable:f}")


class TimeStamps:
    """Reports whether the time stamps of messages are close to the times at which the messages arrive.

    Args:
        now: returns the time, for example ``node.now``.
        earliest, latest: the acceptable range of delays in seconds. A stamp in the future has a negative delay.
    """

    def __init__(self, now: Callable[[], Time], earliest: float = -1.0, latest: float = 5.0) -> None:
        self.earliest, self.latest = earliest, latest
        self._now = now
        self._lock = threading.RLock()
        self._past_count = self._future_count = self._zero_count = 0
        self._delays: list[float] = []  # the minimum and the maximum since the last run; empty if there was no message
        self._has_seen_zero = False

    def tick(self, stamp: Time | float) -> None:
        """Record the time stamp of a message, as a Time or in seconds."""
        seconds = float(stamp if isinstance(stamp, (int, float)) else stamp.to_sec())
        with self._lock:
            if seconds == 0:
                self._has_seen_zero = True
                return
            delay = self._now().to_sec() - seconds
            self._delays = [min([delay, *self._delays]), max([delay, *self._delays])]

    def run(self, status: Status) -> None:
        """Fill in a status with the delays since the last run. Pass this method to the updater as the task."""
        with self._lock:
            minimum_delay, maximum_delay = self._delays or (0.0, 0.0)
            status.summary(OK, "Timestamps are reasonable.")
            if not self._delays:
                status.summary(WARN, "No data since last update.")
            else:
                if minimum_delay < self.earliest:
                    status.summary(ERROR, "Timestamps too far in future seen.")
                    self._future_count += 1
                if maximum_delay > self.latest:
                    status.summary(ERROR, "Timestamps too far in past seen.")
                    self._past_count += 1
                if self._has_seen_zero:
                    status.summary(ERROR, "Zero timestamp seen.")
                    self._zero_count += 1
            for name, value in (
                ("Earliest timestamp delay:", minimum_delay),
                ("Latest timestamp delay:", maximum_delay),
                ("Earliest acceptable timestamp delay:", self.earliest),
                ("Latest acceptable timestamp delay:", self.latest),
            ):
                status.add(name, f"{value:f}")
            status.add("Late diagnostic update count:", self._past_count)
            status.add("Early diagnostic update count:", self._future_count)
            status.add("Zero seen diagnostic update count:", self._zero_count)
            self._delays, self._has_seen_zero = [], False


class Combined:
    """Combines several tasks in one status, which contains the values of all tasks. `Status.merge` merges their
    summaries.

    Args:
        tasks: the tasks.
    """

    def __init__(self, tasks: Sequence[Task] = ()) -> None:
        self.tasks = list(tasks)

    def run(self, status: Status) -> None:
        """Run all tasks, and fill in a status with their results. Pass this method to the updater as the task."""
        initial_summary = status.level, status.message
        merged = Status()
        for task in self.tasks:
            status.summary(*initial_summary)
            task(status)
            merged.merge(status.level, status.message)
        status.summary(merged.level, merged.message)
