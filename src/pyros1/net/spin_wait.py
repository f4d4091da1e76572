"""Waits for data that arrive within microseconds: in a series of short service calls, sleeping and waking up would take
longer than the call itself.
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
"""Seconds to poll for data before sleeping; a shorter wait is considered short."""
MAX_SERIES_GAP: Final = 1e-3
"""Maximum number of seconds between two waits of the same series."""

PREEMPTION_GAP: Final = 250e-6
"""If more seconds than this pass between two polls, another program has used the processor."""
BUSY_TIME: Final = 1.0
"""Seconds for which the machine is then considered busy."""

DONTWAIT: Final = getattr(socket, "MSG_DONTWAIT", 0)
"""Flag for receiving without blocking; 0 if the system has none."""
yield_processor: Final[Callable[[], object]] = getattr(os, "sched_yield", lambda: time.sleep(0))
"""Function that lets other threads run first."""


class SpinWait:
    """Waits for the other side in a series of calls.

    After a short wait, the next wait of the series polls for data for up to SPIN_TIME seconds before it sleeps. After
    a wait that polled in vain, further waits sleep immediately until one is short again. So calls that are slow or
    infrequent do not waste processor time. On a busy machine, waits always sleep: there, a program that is woken up
    gets a processor sooner than a program that keeps using one.
    """

    __slots__ = ("_busy_until", "_last_wait_ended_at", "_was_short")

    def __init__(self) -> None:
        self._busy_until = 0.0
        self._last_wait_ended_at = 0.0
        self._was_short = False

    def wait(self, receive: Callable[[int], ResultT]) -> ResultT:
        """Wait for data, and return the result of ``receive(flags)``, which calls ``recv`` or ``recv_into`` of a
        blocking socket.

        Raises:
            OSError: raised by ``receive``, except for the lack of data while polling.
        """
        start = now = perf_counter()
        if (
            self._was_short
            and DONTWAIT
            and start - self._last_wait_ended_at < MAX_SERIES_GAP
            and start > self._busy_until
        ):
            self._was_short = False
            while now - start < SPIN_TIME:
                try:
                    result = receive(DONTWAIT)
                except BlockingIOError:
                    yield_processor()  # the other side may need this processor
                    previous, now = now, perf_counter()
                    if now - previous > PREEMPTION_GAP:
                        self._busy_until = now + BUSY_TIME
                    continue
                self._was_short = True
                self._last_wait_ended_at = now
                return result
            return receive(0)
        result = receive(0)
        self._last_wait_ended_at = perf_counter()
        self._was_short = self._last_wait_ended_at - start < SPIN_TIME
        return result
