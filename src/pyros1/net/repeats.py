"""Counts repeated log lines instead of writing them, so that a peer cannot fill a disk or hide other lines."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable

PERIOD = 30.0
"""Length of a period in seconds: a text is written once in each."""
MOST_TEXTS = 20
"""Most different texts from one place in the program that are written in one period."""


class _Period:
    """What one place in the program has written in the current period."""

    def __init__(self, emit: Callable[[str], None]) -> None:
        self.emit = emit
        self.counts: dict[str, int] = {}
        self.others = 0


class Repeats:
    """Filter that writes each text once per period, and then how often it was repeated.

    Args:
        later: ``later(seconds, function, argument)`` calls a function after some seconds, as a loop's ``call_later``
            does.
    """

    def __init__(self, later: Callable[..., object]) -> None:
        self._later = later
        self._periods: dict[Hashable, _Period] = {}
        self._lock = threading.RLock()  # a signal handler that interrupts `say` may end the node

    def say(self, place: Hashable, text: str, emit: Callable[[str], None], most: int = MOST_TEXTS) -> None:
        """Write a text, or count it. Any thread.

        Args:
            place: the place in the program that it comes from: the limit holds for each place.
            emit: the function that writes it.
            most: most different texts from that place that are written in one period.
        """
        with self._lock:
            period = self._periods.get(place)
            fresh = period is None
            if period is None:
                period = self._periods[place] = _Period(emit)
            known = text in period.counts
            room = len(period.counts) < most
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
            period.emit(f"{period.others} more messages like the last ones were suppressed")

    def close(self) -> None:
        """Write the counts so far."""
        for place in list(self._periods):
            self._end(place)
