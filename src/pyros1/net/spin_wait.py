"""Waits for data that come within microseconds: in a series of short calls of a service, to sleep and to be woken takes
longer than the call.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable
from time import perf_counter
from typing import Final, TypeVar

ResultT = TypeVar("ResultT")

SPIN_TIME: Final = 150e-6
"""Seconds that a side polls for data before it sleeps; waits that are shorter than this count as short."""
MAX_SERIES_GAP: Final = 1e-3
"""Seconds after a wait within which the next one belongs to the same series."""

PREEMPTION_GAP: Final = 250e-6
"""Seconds between two polls that show that another program has used the processor meanwhile."""
BUSY_TIME: Final = 1.0
"""Seconds for which a machine counts as busy after that."""

DONTWAIT: Final = getattr(socket, "MSG_DONTWAIT", 0)
"""Flag of a receive that does not wait; 0 where there is none."""
yield_processor: Final[Callable[[], object]] = getattr(os, "sched_yield", lambda: time.sleep(0))
"""Let other threads run first."""


class SpinWait:
    """How one side of a series of calls waits for the other.

    After a short wait, the next one of the series polls for data for up to SPIN_TIME seconds before it sleeps. After
    one that polled in vain, waits sleep at once until one is short again. So calls that are slow, or come one now and
    then, cost no more processor time than they need. On a busy machine all sleep: a woken program gets a processor
    sooner there than one that never left it.
    """

    __slots__ = ("_busy_until", "_ended", "_short")

    def __init__(self) -> None:
        self._busy_until = 0.0
        self._ended = 0.0
        self._short = False

    def wait(self, receive: Callable[[int], ResultT]) -> ResultT:
        """Return what ``receive(flags)`` returns, a call of a blocking socket's ``recv`` or ``recv_into``.

        Raises:
            OSError: what it raises when it sleeps, and errors other than that no data have arrived.
        """
        start = now = perf_counter()
        if self._short and DONTWAIT and start - self._ended < MAX_SERIES_GAP and start > self._busy_until:
            self._short = False
            while now - start < SPIN_TIME:
                try:
                    result = receive(DONTWAIT)
                except BlockingIOError:
                    yield_processor()  # the other side may need this processor
                    previous, now = now, perf_counter()
                    if now - previous > PREEMPTION_GAP:
                        self._busy_until = now + BUSY_TIME
                    continue
                self._short = True
                self._ended = now
                return result
            return receive(0)
        result = receive(0)
        self._ended = perf_counter()
        self._short = self._ended - start < SPIN_TIME
        return result
