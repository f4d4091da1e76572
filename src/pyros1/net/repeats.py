"""Lines that others cause are counted instead of repeated, so that nobody fills a disk or hides what matters."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable

PERIOD = 30.0
"""Seconds in which a text is written once."""
MOST_TEXTS = 20
"""Different texts of one place in the program that are written in that time."""


class _Period:
    """What one place in the program has said lately."""

    def __init__(self, emit: Callable[[str], None]) -> None:
        self.emit = emit
        self.counts: dict[str, int] = {}
        self.others = 0


class Repeats:
    """Writes each text once in a while, and how often it came besides.

    Args:
        later: ``later(seconds, function, argument)`` calls a function some time later, as a loop's ``call_later``.
    """

    def __init__(self, later: Callable[..., object]) -> None:
        self._later = later
        self._periods: dict[Hashable, _Period] = {}
        self._lock = threading.RLock()  # a signal handler may end the node on top of `say`

    def say(self, place: Hashable, text: str, emit: Callable[[str], None]) -> None:
        """Write a text, or count it. Any thread.

        Args:
            place: where in the program it comes from: what a place may say is limited together.
            emit: writes it.
        """
        with self._lock:
            period = self._periods.get(place)
            fresh = period is None
            if period is None:
                period = self._periods[place] = _Period(emit)
            known = text in period.counts
            room = len(period.counts) < MOST_TEXTS
            if known:
                period.counts[text] += 1
            elif room:
                period.counts[text] = 0
            else:
                period.others += 1
        if fresh:
            self._later(PERIOD, self._end, place)
        if not known and room:
            emit(text)

    def _end(self, place: Hashable) -> None:
        with self._lock:
            period = self._periods.pop(place, None)
        if period is None:
            return
        for text, count in period.counts.items():
            if count:
                period.emit(f"{text} (repeated {count} times)" if count > 1 else f"{text} (repeated once)")
        if period.others:
            period.emit(f"{period.others} more messages like the last ones were left out")

    def close(self) -> None:
        """Write what has been counted so far."""
        for place in list(self._periods):
            self._end(place)
