"""Rates, sleeps and timers (https://wiki.ros.org/rospy/Overview/Time)."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import TimeMovedBackwardsError
from pyros1.node.clock import TimerEvent
from rospy.exceptions import ROSInitException, ROSInterruptException, ROSTimeMovedBackwardsException
from rospy.rostime import Duration, wallsleep

__all__ = ["Rate", "Timer", "TimerEvent", "sleep"]


def _node() -> Any:
    if PROCESS.node is None:
        raise ROSInitException("time is not initialized. Have you called init_node()?")
    return PROCESS.node


def _seconds(value: Any) -> float:
    return float(value.to_sec()) if hasattr(value, "to_sec") else float(value)


def sleep(duration: Any) -> None:
    """Sleep in the node's time.

    Args:
        duration: seconds, or a Duration.

    Raises:
        ROSInterruptException: the node is shutting down.
        ROSTimeMovedBackwardsException: simulated time jumped back.
    """
    seconds = _seconds(duration)
    if PROCESS.node is None:
        wallsleep(seconds)
        return
    try:
        alive = PROCESS.node.sleep(seconds)
    except TimeMovedBackwardsError as error:
        raise ROSTimeMovedBackwardsException(error.args[0] if error.args else 0) from None
    if not alive:
        raise ROSInterruptException("ROS shutdown request")


class Rate:
    """Rate of a loop.

    Args:
        hz: frequency.
        reset: go on after simulated time has jumped back, in place of an exception.
    """

    def __init__(self, hz: float, reset: bool = False) -> None:
        self._rate = _node().rate(hz)
        self.sleep_dur = Duration.from_sec(1.0 / hz)

    def remaining(self) -> Duration:
        """Return the time left in the current cycle."""
        return Duration.from_sec(self._rate.remaining())

    def sleep(self) -> None:
        """Sleep until the end of the current cycle; raises ROSInterruptException when the node is shutting down."""
        if not self._rate.sleep():
            raise ROSInterruptException("ROS shutdown request")


class Timer:
    """Calls a function periodically.

    Args:
        period: a Duration.
        callback: called with a TimerEvent.
        oneshot: call only once.
        reset: go on after simulated time has jumped back.
    """

    def __init__(self, period: Any, callback: Any, oneshot: bool = False, reset: bool = False) -> None:
        self._timer: Any = None
        self._ended = False
        self._make = lambda node: self._begin(node, _seconds(period), callback, oneshot)
        PROCESS.when_started(self._make)

    def _begin(self, node: Any, period: float, callback: Any, oneshot: bool) -> None:
        if not self._ended:
            self._timer = node.timer(period, callback, oneshot)

    def shutdown(self) -> None:
        """End the timer."""
        self._ended = True
        PROCESS.forget(self._make)
        if self._timer is not None:
            self._timer.shutdown()

    def is_alive(self) -> bool:
        """Return whether further calls will come."""
        return self._timer is not None and bool(self._timer.alive)

    def join(self, timeout: float | None = None) -> None:
        """Wait for the timer's end."""
        if self._timer is not None:
            self._timer.join(1e9 if timeout is None else timeout)
