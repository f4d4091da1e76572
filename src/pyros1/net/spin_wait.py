"""Waits for data that arrive within microseconds, by polling: sleeping and waking up would take longer."""

from __future__ import annotations

import math
import os
import socket
import time
from collections.abc import Callable
from time import perf_counter
from typing import Final, TypeVar

from pyros1.net.processors import ProcessorTimes, could_poll, has_realtime_priority, read_processor_times

ResultT = TypeVar("ResultT")

SPIN_TIME: Final = 150e-6
"""Seconds to poll for data before sleeping. In `SpinWait`, a wait that takes less than this counts as short."""
MAX_SERIES_GAP: Final = 1e-3
"""Maximum number of seconds between two waits of the same series."""

PREEMPTION_GAP: Final = 250e-6
"""If more than this many seconds pass between two polls, another program has used the processor."""
MIN_PAUSE: Final = 0.01
MAX_PAUSE: Final = 1.0
"""Minimum and maximum duration in seconds of the pause in polling after an interruption by another program."""
CHECKED_PAUSE: Final = 0.04
"""Minimum duration in seconds of a pause after which idle times are compared: the system reports them in hundredths."""

POLLING_PAUSED: Final = "polling paused"
"""Note at the end of a connection's description in ``getBusInfo``: the subscription has ``low_latency=True``, but the
node is not polling for its messages at the moment, see `PollGuard`.
"""

DONTWAIT: Final = getattr(socket, "MSG_DONTWAIT", 0)
"""Flag for receiving without blocking; 0 if the system has none."""
yield_processor: Final[Callable[[], object]] = getattr(os, "sched_yield", lambda: time.sleep(0))
"""Function that lets other threads run first."""


class PollGuard:
    """Decides whether to poll. After another program has interrupted the polling, polling pauses for a while.

    A program that polls on a busy machine loses the processor for milliseconds, whereas a program that sleeps gets it
    as soon as its data arrive. If another interruption follows soon after a pause, the next pause is twice as long. So
    a single interruption costs little. After a longer pause, polling begins only if a processor was idle during it, and
    if a limit on the processor time of this program leaves enough (see `could_poll`): to poll just to find out that the
    machine is still busy would cost milliseconds, too. For the same reason, a pause comes first. On a busy machine,
    even a few polls do lasting harm: they spread two programs over two processors, whereas programs that sleep and wake
    each other often end up on the same one, where the switch between them is faster. Threads with a real-time priority
    poll without such checks: other programs do not interrupt them.

    Args:
        assume_idle: whether to begin without a pause.

    Attributes:
        paused_until: time until which polling pauses, in seconds on the caller's clock.
        is_busy: whether there was too little processor time left when the guard last checked.
    """

    __slots__ = ("_interrupted_at", "_is_new", "_pause", "_times_before", "is_busy", "paused_until")

    def __init__(self, assume_idle: bool = False) -> None:
        self.paused_until = 0.0
        self.is_busy = False
        self._is_new = not assume_idle
        self._interrupted_at = -math.inf
        self._pause = 0.0
        self._times_before: ProcessorTimes | None = None  # at the start of the pause; None if it need not be compared

    def may_poll(self, now: float) -> bool:
        """Return whether polling is allowed at the given time. Several threads may share a guard."""
        if self._is_new:
            if not has_realtime_priority():
                self._begin_pause(now, CHECKED_PAUSE, read_processor_times())
                self._is_new = False  # afterwards: until the pause has begun, other threads must not poll either
                return False
            self._is_new = False
        if now < self.paused_until:
            return False
        before = self._times_before
        if before is None:
            return True
        times = read_processor_times()
        self.is_busy = not could_poll(before, times) and not has_realtime_priority()
        if self.is_busy:
            self._begin_pause(now, MAX_PAUSE, times)
            return False
        self._times_before = None
        self._pause = 0.0  # the interruptions before were rare ones, or by other threads of this program
        return True

    def note_poll(self, previous: float, now: float) -> bool:
        """Record two successive polls. If another program ran in between, begin a pause and return True."""
        if now - previous <= PREEMPTION_GAP:
            return False
        is_frequent = now - self._interrupted_at < 3 * self._pause
        pause = min(2 * self._pause, MAX_PAUSE) if is_frequent else MIN_PAUSE
        self._interrupted_at = now
        self._begin_pause(now, pause, read_processor_times() if pause >= CHECKED_PAUSE else None)
        return True

    def _begin_pause(self, now: float, pause: float, times: ProcessorTimes | None) -> None:
        self.paused_until = now + pause  # first: other threads must not compare times with those of this moment
        self._pause, self._times_before = pause, times


class SpinWait:
    """Waits for the other side in a series of calls.

    After a short wait, the next wait of the series polls for data for up to SPIN_TIME seconds before it sleeps. If no
    data arrive during that time, further waits sleep immediately until one is short again. So calls that are slow or
    infrequent do not waste processor time. On a busy machine, and until it is known not to be busy, waits always sleep,
    see `PollGuard`.
    """

    __slots__ = ("_guard", "_last_wait_ended_at", "_was_short")

    def __init__(self) -> None:
        self._guard = PollGuard()
        self._last_wait_ended_at = 0.0
        self._was_short = False

    def wait(self, receive: Callable[[int], ResultT]) -> ResultT:
        """Wait for data, and return the result of ``receive(flags)``, which calls ``recv`` or ``recv_into`` of a
        blocking socket.

        Raises:
            OSError: raised by ``receive``; a lack of data while polling is not an error.
        """
        start = now = perf_counter()
        if (
            self._was_short
            and DONTWAIT
            and start - self._last_wait_ended_at < MAX_SERIES_GAP
            and self._guard.may_poll(start)
        ):
            self._was_short = False
            while now - start < SPIN_TIME:
                try:
                    result = receive(DONTWAIT)
                except BlockingIOError:
                    yield_processor()  # the other side may need this processor
                    previous, now = now, perf_counter()
                    if self._guard.note_poll(previous, now):
                        break
                    continue
                self._was_short = True
                self._last_wait_ended_at = now
                return result
            return receive(0)
        result = receive(0)
        self._last_wait_ended_at = perf_counter()
        self._was_short = self._last_wait_ended_at - start < SPIN_TIME
        return result
