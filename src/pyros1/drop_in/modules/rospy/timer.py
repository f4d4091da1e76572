"""Rates, sleeps and timers (https://wiki.ros.org/rospy/Overview/Time)."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import TimeMovedBackwardsError
from pyros1.ground.timing import Duration as _Duration
from pyros1.ground.timing import Time as _Time
from pyros1.ground.timing import scalar
from rospy.exceptions import ROSInterruptException, ROSTimeMovedBackwardsException
from rospy.rostime import Duration, Time, get_rostime, sleep_in_program_time, time_set_by_program, wallsleep


class TimerEvent:
    """The argument of a timer's callback.

    Args:
        last_expected, last_real: when the previous call was due, and when it was made; None for the first call.
        current_expected, current_real: when this call was due, and when it was made.
        last_duration: duration of the previous callback in seconds; None for the first call.
    """

    def __init__(
        self,
        last_expected: Time | None,
        last_real: Time | None,
        current_expected: Time,
        current_real: Time,
        last_duration: float | None,
    ) -> None:
        self.last_expected = last_expected
        self.last_real = last_real
        self.current_expected = current_expected
        self.current_real = current_real
        self.last_duration = last_duration


_NS = 1_000_000_000
__all__ = ["Rate", "Timer", "TimerEvent", "sleep"]


def _now() -> int:
    """Return the node's time in nanoseconds. Wall time needs no object, which matters in 1 kHz loops."""
    node = PROCESS.node
    return get_rostime().to_nsec() if node is None or node.simulated_time or time_set_by_program() else time.time_ns()


def sleep(duration: float | _Duration) -> None:
    """Sleep in the node's time. In wall time, the sleep returns early, without an exception, when the node shuts down.

    Args:
        duration: seconds, or a Duration.

    Raises:
        ROSInterruptException: the node is shutting down, in simulated time.
        ROSTimeMovedBackwardsException: simulated time jumped back.
    """
    seconds = duration.to_sec() if isinstance(duration, _Duration) else duration
    node = PROCESS.node
    if seconds < 0:
        if node is not None and node.simulated_time and (PROCESS.is_shutdown or not node.ok()):
            raise ROSInterruptException("ROS shutdown request")
        return
    if time_set_by_program() is not None:
        sleep_in_program_time(seconds)
        return
    if node is None or PROCESS.is_shutdown:
        if node is not None and node.simulated_time:
            raise ROSInterruptException("ROS shutdown request")
        wallsleep(seconds)
        return
    start = node.now() if node.simulated_time else None
    try:
        is_running = node.sleep(seconds)
    except TimeMovedBackwardsError:
        jump = (start - node.now()).to_sec() if start else 0.0
        raise ROSTimeMovedBackwardsException(jump) from None
    if not is_running and node.simulated_time:
        raise ROSInterruptException("ROS shutdown request")


class Rate:
    """Keeps a loop at a fixed rate.

    Args:
        hz: the rate in Hz.
        reset: whether to continue after simulated time has jumped back, instead of raising an exception.

    Attributes:
        last_time: when the current cycle started.
        sleep_dur: length of a cycle.
    """

    def __init__(self, hz: float, reset: bool = False) -> None:
        self._last = get_rostime().to_nsec()
        self._cycle = int(scalar(1e9 / hz))
        self._reset = reset

    # Integer nanoseconds: 1 kHz loops spend much of their time here.

    @property
    def last_time(self) -> Time:
        return Time(*divmod(self._last, _NS))

    @last_time.setter
    def last_time(self, time: _Time) -> None:
        self._last = time.to_nsec()

    @property
    def sleep_dur(self) -> Duration:
        return Duration(*divmod(self._cycle, _NS))

    @sleep_dur.setter
    def sleep_dur(self, duration: _Duration) -> None:
        self._cycle = duration.to_nsec()

    def remaining(self) -> Duration:
        """Return the remaining time of the current cycle."""
        return Duration(*divmod(self._remaining_ns(get_rostime().to_nsec()), _NS))

    def _remaining_ns(self, now: int) -> int:
        self._last = min(self._last, now)  # if time has jumped back, the cycle starts now
        return self._cycle - (now - self._last)

    def sleep(self) -> None:
        """Sleep until the end of the current cycle. If that was over two cycles ago, the next cycle starts now.

        Raises:
            ROSInterruptException, ROSTimeMovedBackwardsException: see `sleep`.
        """
        now = _now()  # before the sleep, as in stock ROS: a jump of simulated time affects the next sleep
        try:
            sleep(self._remaining_ns(now) / _NS)
        except ROSTimeMovedBackwardsException:
            if not self._reset:
                raise
            self._last = get_rostime().to_nsec()
            return
        self._last += self._cycle
        if now - self._last > self._cycle * 2:
            self._last = now


class Timer(threading.Thread):
    """Calls a function periodically, in a separate thread.

    Args:
        period: a Duration.
        callback: called with a TimerEvent. If it raises an exception, the timer stops.
        oneshot: whether to call only once.
        reset: the argument of the timer's `Rate`. When simulated time jumps back, the timer continues in either case,
            as in the last release of ROS Noetic. In earlier releases, it stopped unless this was true.
    """

    def __init__(
        self, period: _Duration, callback: Callable[[TimerEvent], object], oneshot: bool = False, reset: bool = False
    ) -> None:
        super().__init__(daemon=True)
        self._period = period
        self._callback = callback
        self._oneshot = oneshot
        self._reset = reset
        self._stopped = False
        self.start()

    def shutdown(self) -> None:
        """Stop the timer: no more calls are made."""
        self._stopped = True

    def run(self) -> None:
        """Make the calls, in the timer's thread."""
        rate = Rate(1.0 / self._period.to_sec(), reset=self._reset)
        expected: Any = rate.last_time + self._period
        last_expected: Any = None
        last_real: Any = None
        last_duration = None
        while not (PROCESS.is_shutdown or self._stopped):
            try:
                rate.sleep()
            except ROSTimeMovedBackwardsException:
                pass  # for example, a bag is played again; the next cycle begins at the new time
            except ROSInterruptException:
                if PROCESS.is_shutdown:
                    return
                raise
            if self._stopped or PROCESS.is_shutdown or not (PROCESS.node is None or PROCESS.node.ok()):
                return
            real = get_rostime()
            start = time.perf_counter()
            self._callback(TimerEvent(last_expected, last_real, _as_time(expected), real, last_duration))
            if self._oneshot:
                return
            last_duration = time.perf_counter() - start
            last_expected, last_real = _as_time(expected), real
            expected = expected + self._period


def _as_time(value: Any) -> Time:
    return Time(value.secs, value.nsecs)
