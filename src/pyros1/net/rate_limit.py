"""Counts repeated log lines instead of writing them, so that a peer cannot fill a disk or hide other lines."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable

PERIOD = 30.0
"""Length of a period in seconds: a text is written once in each."""
MAX_TEXTS = 20
"""Maximum number of different texts from one place in the program that are written in one period."""


class _Period:
    """What one place in the program has written in the current period."""

    def __init__(self, emit: Callable[[str], None]) -> None:
        self.emit = emit
        self.counts: dict[str, int] = {}
        self.suppressed = 0


class RepeatCounter:
    """Filter that writes each text once per period, and then how often it was repeated.

    Args:
        schedule: ``schedule(seconds, function, argument)`` calls a function after some seconds, as a loop's
            ``call_later`` does.
    """

    def __init__(self, schedule: Callable[..., object]) -> None:
        self._schedule = schedule
        self._periods: dict[Hashable, _Period] = {}
        self._lock = threading.RLock()  # a signal handler that interrupts `log` may end the node

    def log(self, site: Hashable, text: str, emit: Callable[[str], None], max_texts: int = MAX_TEXTS) -> None:
        """Write a text, or count it. Any thread.

        Args:
            site: the place in the program that it comes from: the limit holds for each place.
            emit: the function that writes it.
            max_texts: maximum number of different texts from that place that are written in one period.
        """
        with self._lock:
            period = self._periods.get(site)
            fresh = period is None
            if period is None:
                period = self._periods[site] = _Period(emit)
            known = text in period.counts
            has_room = len(period.counts) < max_texts
            if known:
                period.counts[text] += 1
            elif has_room:
                period.counts[text] = 0
            else:
                period.suppressed += 1
        if fresh:
            self._schedule(PERIOD, self._end, site)
        if not known and has_room:
            emit(text)

    def _end(self, site: Hashable) -> None:
        with self._lock:
            period = self._periods.pop(site, None)
        if period is None:
            return
        for text, count in period.counts.items():
            if count:
                period.emit(f"{text} (repeated {count} times)" if count > 1 else f"{text} (repeated once)")
        if period.suppressed:
            period.emit(f"{period.suppressed} more messages like the last ones were suppressed")

    def close(self) -> None:
        """Write the counts so far."""
        for site in list(self._periods):
            self._end(site)
