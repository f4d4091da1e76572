"""Counts repeated log lines instead of writing them, so that a peer cannot fill a disk or hide other lines."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable

PERIOD = 30.0
"""Length of a period in seconds; each message is written at most once per period."""
MAX_TEXTS = 20
"""Maximum number of different messages written per period from one place in the program."""


class _Period:
    """The messages that one place in the program has logged in the current period."""

    def __init__(self, emit: Callable[[str], None]) -> None:
        self.emit = emit
        self.repeat_counts: dict[str, int] = {}
        self.num_suppressed = 0


class RepeatCounter:
    """A filter that writes each message once per period; at the end of the period, it writes how often each message was
    repeated.

    Args:
        schedule: ``schedule(seconds, function, argument)`` calls a function after that many seconds, like a loop's
            ``call_later``.
    """

    def __init__(self, schedule: Callable[..., object]) -> None:
        self._schedule = schedule
        self._periods: dict[Hashable, _Period] = {}
        self._lock = threading.RLock()  # a signal handler that interrupts `log` may call `log` or `close`

    def log(self, site: Hashable, text: str, emit: Callable[[str], None], max_texts: int = MAX_TEXTS) -> None:
        """Write a message, or count it as a repetition. Thread-safe.

        Args:
            site: the place in the program that logs the message; the limit applies to each place separately.
            text: the message.
            emit: the function that writes messages.
            max_texts: maximum number of different messages written per period from that place.
        """
        with self._lock:
            period = self._periods.get(site)
            is_new = period is None
            if period is None:
                period = self._periods[site] = _Period(emit)
            is_known = text in period.repeat_counts
            has_room = len(period.repeat_counts) < max_texts
            if is_known:
                period.repeat_counts[text] += 1
            elif has_room:
                period.repeat_counts[text] = 0
            else:
                period.num_suppressed += 1
        if is_new:
            self._schedule(PERIOD, self._end_period, site)
        if not is_known and has_room:
            emit(text)

    def _end_period(self, site: Hashable) -> None:
        with self._lock:
            period = self._periods.pop(site, None)
        if period is None:
            return
        for text, count in period.repeat_counts.items():
            if count:
                period.emit(f"{text} (repeated {count} times)" if count > 1 else f"{text} (repeated once)")
        if period.num_suppressed:
            period.emit(f"{period.num_suppressed} similar messages were suppressed")

    def close(self) -> None:
        """Write how often messages have been repeated so far, and end all periods."""
        for site in list(self._periods):
            self._end_period(site)
