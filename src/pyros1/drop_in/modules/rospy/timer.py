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
from rospy.exceptions import ROSInterruptException, ROSTimeMovedBackwardsException
from rospy.rostime import Duration, Time, get_rostime, wallsleep


class TimerEvent:
    """The argument of a timer's callback.

    Args:
        last_expected, last_real: when the previous call should have happened, and did; None at the first.
        current_expected, current_real: when this call should have happened, and did.
        last_duration: seconds that the previous callback took; None at the first.
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


__all__ = ["Rate", "Timer", "TimerEvent", "sleep"]


def sleep(duration: float | _Duration) -> None:
    """Sleep in the node's time. A sleep in wall time ends early, without an exception, when the node begins to end.

    Args:
        duration: seconds, or a Duration.

    Raises:
        ROSInterruptException: the node is shutting down, in simulated time.
        ROSTimeMovedBackwardsException: simulated time jumped back.
    """
    seconds = duration.to_sec() if isinstance(duration, _Duration) else duration
    if seconds < 0:
        return
    node = PROCESS.node
    if node is None or PROCESS.is_shutdown:
        if node is not None and node.simulated_time:
            raise ROSInterruptException("ROS shutdown request")
        wallsleep(seconds)
        return
    start = node.now()
    try:
        alive = node.sleep(seconds)
    except TimeMovedBackwardsError:
        raise ROSTimeMovedBackwardsException((start - node.now()).to_sec()) from None
    if not alive and node.simulated_time:
        raise ROSInterruptException("ROS shutdown request")


class Rate:
    """Rate of a loop.

    Args:
        hz: frequency.
        reset: go on after simulated time has jumped back, in place of an exception.

    Attributes:
        last_time: when the current cycle began.
        sleep_dur: length of a cycle.
    """

    def __init__(self, hz: float, reset: bool = False) -> None:
        self.last_time: Any = get_rostime()
        self.sleep_dur = Duration(0, int(1e9 / hz))
        self._reset = reset

    def remaining(self) -> Duration:
        """Return the time left in the current cycle."""
        left = self._left(get_rostime())
        return Duration(left.secs, left.nsecs)

    def _left(self, now: _Time) -> _Duration:
        self.last_time = min(self.last_time, now)  # now, if time has jumped back
        return self.sleep_dur - (now - self.last_time)

    def sleep(self) -> None:
        """Sleep until the end of the current cycle. More than two cycles late, the next one begins now.

        Raises:
            ROSInterruptException, ROSTimeMovedBackwardsException: as `sleep`.
        """
        now = get_rostime()  # a jump of simulated time in the sleep is seen by the next one, as in stock
        try:
            sleep(self._left(now))
        except ROSTimeMovedBackwardsException:
            if not self._reset:
                raise
            self.last_time = get_rostime()
            return
        self.last_time = self.last_time + self.sleep_dur
        if now - self.last_time > self.sleep_dur * 2:
            self.last_time = now


class Timer(threading.Thread):
    """Calls a function periodically, in a thread of its own.

    Args:
        period: a Duration.
        callback: called with a TimerEvent. If it raises, the timer ends.
        oneshot: call only once.
        reset: go on after simulated time has jumped back.
    """

    def __init__(
        self, period: _Duration, callback: Callable[[TimerEvent], object], oneshot: bool = False, reset: bool = False
    ) -> None:
        super().__init__(daemon=True)
        self._period = period
        self._callback = callback
        self._oneshot = oneshot
        self._reset = reset
        self._ended = False
        self.start()

    def shutdown(self) -> None:
        """End the timer: no call begins any more."""
        self._ended = True

    def run(self) -> None:
        """Make the calls, in the timer's thread."""
        rate = Rate(1.0 / self._period.to_sec(), reset=self._reset)
        expected: Any = rate.last_time + self._period
        last_expected: Any = None
        last_real: Any = None
        took = None
        while not (PROCESS.is_shutdown or self._ended):
            try:
                rate.sleep()
            except ROSInterruptException:
                if PROCESS.is_shutdown:
                    return
                raise
            if self._ended or PROCESS.is_shutdown:
                return
            real = get_rostime()
            start = time.perf_counter()
            self._callback(TimerEvent(last_expected, last_real, _time(expected), real, took))
            if self._oneshot:
                return
            took = time.perf_counter() - start
            last_expected, last_real = _time(expected), real
            expected = expected + self._period


def _time(value: Any) -> Time:
    return Time(value.secs, value.nsecs)
