"""Computes each topic's messages and bytes per second from increasing counts. No I/O."""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Mapping
from typing import NamedTuple

PERIOD = 1.0
"""Seconds between samples."""
_SAMPLES = 4
"""Number of samples; rates are averages from the oldest one to the newest."""


class Count(NamedTuple):
    """The total numbers of messages and bytes."""

    messages: int
    bytes: int


class Rate(NamedTuple):
    """Messages and bytes per second."""

    messages: float
    bytes: float


class Rates:
    """The rates of topics, which may have any keys."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, Mapping[Hashable, Count]]] = deque(maxlen=_SAMPLES)

    def is_due(self, now: float) -> bool:
        """Return whether it is time for another sample."""
        return not self._samples or now - self._samples[-1][0] >= PERIOD

    def add(self, counts: Mapping[Hashable, Count], now: float) -> None:
        """Add a sample."""
        self._samples.append((now, counts))

    def rate(self, key: Hashable) -> Rate | None:
        """Return the rate of a topic; None until there are two samples."""
        if len(self._samples) < 2:
            return None
        (since, first), (until, last) = self._samples[0], self._samples[-1]
        before, now = (sample.get(key, Count(0, 0)) for sample in (first, last))
        if now.messages < before.messages:  # counting has restarted
            before = Count(0, 0)
        duration = until - since
        return Rate((now.messages - before.messages) / duration, (now.bytes - before.bytes) / duration)
