"""The node's time, and sleeping (https://wiki.ros.org/rospy/Overview/Time)."""

from __future__ import annotations

import threading
import time
from typing import Any

import pyros1.ground.timing
from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from rospy.exceptions import ROSInitException, ROSInterruptException, ROSTimeMovedBackwardsException

_rostime_cond = threading.Condition()
_notifications_started: list[bool] = []
"""Not empty after the first call of `get_rostime_cond`: from then on, the condition is notified of time changes."""
_program_time_and_clock: list[Any] = []
"""The time set by the program, and the time on /clock at that moment."""


def _as_rospy(value: Any) -> Any:
    """Convert a time or duration, such as the result of a calculation, to rospy's class."""
    if value.__class__ is pyros1.ground.timing.Duration:
        return Duration(value.secs, value.nsecs)
    if value.__class__ is pyros1.ground.timing.Time:
        return Time(value.secs, value.nsecs)
    return value


class Duration(pyros1.ground.timing.Duration):
    """A duration.

    Args:
        secs: seconds; a float is allowed if nsecs is 0.
        nsecs: nanoseconds.
    """

    __slots__ = ()

    @classmethod
    def from_sec(cls, float_secs: float) -> Duration:
        """Return the duration of a number of seconds."""
        return super().from_sec(float_secs)

    def __add__(self, other: object) -> Any:
        return _as_rospy(super().__add__(other))

    def __sub__(self, other: object) -> Any:
        return _as_rospy(super().__sub__(other))

    def __neg__(self) -> Any:
        return _as_rospy(super().__neg__())

    def __mul__(self, factor: object) -> Any:
        return _as_rospy(super().__mul__(factor))

    def __floordiv__(self, other: object) -> Any:
        return _as_rospy(super().__floordiv__(other))

    def __truediv__(self, other: object) -> Any:
        return _as_rospy(super().__truediv__(other))

    def __mod__(self, other: object) -> Any:
        return _as_rospy(super().__mod__(other))

    __rmul__ = __mul__

    def __repr__(self) -> str:
        return f"rospy.Duration[{self.to_nsec()}]"


class Time(pyros1.ground.timing.Time):
    """A point in time.

    Args:
        secs: seconds; a float is allowed if nsecs is 0.
        nsecs: nanoseconds.

    Raises:
        TypeError: the time is negative.
    """

    __slots__ = ()

    def __add__(self, other: object) -> Any:
        return _as_rospy(super().__add__(other))

    __radd__ = __add__

    def __sub__(self, other: object) -> Any:
        difference = super().__sub__(other)
        return difference if isinstance(other, pyros1.ground.timing.Time) else _as_rospy(difference)

    def __repr__(self) -> str:
        return f"rospy.Time[{self.to_nsec()}]"

    @staticmethod
    def now() -> Time:
        """Return the current time.

        Raises:
            ROSInitException: the node has not been started.
        """
        return get_rostime()

    @classmethod
    def from_sec(cls, float_secs: float) -> Time:
        """Return the time for a number of seconds since the epoch."""
        return super().from_sec(float_secs)

    @classmethod
    def from_seconds(cls, float_secs: float) -> Time:
        """Return the time for a number of seconds since the epoch; `from_sec` is the newer name."""
        return super().from_sec(float_secs)


def _set_rostime(t: Any) -> None:
    """Set the time, for tests. Time then stands still until `switch_to_wallclock` or a message on /clock.

    Args:
        t: a Time of genpy or rospy.

    Raises:
        ValueError: ``t`` is not a Time.
    """
    if not isinstance(t, pyros1.ground.timing.Time):
        raise ValueError(f"must be Time instance: {t.__class__}")
    _set_program_time(Time(t.secs, t.nsecs))


def _set_program_time(value: Time | None) -> None:
    globals()["_rostime_current"] = value  # programs read and write this variable as well
    time_set_by_program()
    _notify_waiters(None)


def time_set_by_program() -> Time | None:
    """Return the time set by the program; None if it has not set one, or /clock has changed since."""
    program_time: Time | None = globals().get("_rostime_current")
    node = PROCESS.node
    if program_time is None or node is None or not node.simulated_time:
        return program_time
    clock = node.now()
    if not _program_time_and_clock or _program_time_and_clock[0] is not program_time:
        _program_time_and_clock[:] = [program_time, clock]
    elif _program_time_and_clock[1] is not clock:
        _program_time_and_clock.clear()
        globals().pop("_rostime_current", None)
        return None
    return program_time


def sleep_in_program_time(seconds: float) -> None:
    """Sleep until the time set by the program has advanced.

    Raises:
        ROSInterruptException: the node is shutting down.
        ROSTimeMovedBackwardsException: the program has set the time back.
    """
    start = get_rostime()
    while not (start.to_nsec() or PROCESS.is_shutdown):
        start = _next_time()
    end = start + Duration.from_sec(seconds)
    now = get_rostime()
    while start <= now < end and not PROCESS.is_shutdown:
        now = _next_time()
    if now < start:
        raise ROSTimeMovedBackwardsException((start - now).to_sec())
    if PROCESS.is_shutdown:
        raise ROSInterruptException("ROS shutdown request")


def _next_time() -> Time:
    with _rostime_cond:
        _rostime_cond.wait(0.2)
    return get_rostime()


def get_rostime() -> Time:
    """Return the node's time: wall time, simulated time from /clock, or a time that the program has set.

    Raises:
        ROSInitException: the node has not been started.
    """
    node = PROCESS.node
    program_time = time_set_by_program()
    if program_time is not None and (node is not None or PROCESS.has_wall_clock):
        return program_time
    if node is None:
        if not PROCESS.has_wall_clock:
            raise ROSInitException("time is not initialized. Have you called init_node()?")
    elif node.simulated_time:
        now = node.now()
        return Time(now.secs, now.nsecs)
    return Time.of_clock(time.time_ns())


def get_time() -> float:
    """Return the node's time in seconds.

    Raises:
        ROSInitException: the node has not been started.
    """
    return get_rostime().to_sec()


def is_wallclock() -> bool:
    """Return whether the node uses wall time."""
    return time_set_by_program() is None and (PROCESS.node is None or not PROCESS.node.simulated_time)


def is_rostime_initialized() -> bool:
    """Return whether a clock is available."""
    return PROCESS.has_wall_clock or PROCESS.node is not None


def set_rostime_initialized(val: bool) -> None:
    """Set whether wall time is available without a node."""
    PROCESS.has_wall_clock = val


def switch_to_wallclock() -> None:
    """Use wall time if there is no node, or instead of a time that the program has set.

    Raises:
        NotImplementedError: the node uses simulated time, which cannot be changed.
    """
    _set_program_time(None)
    if not is_wallclock():
        raise NotImplementedError("pyros1 cannot switch a running node from simulated to wall time")
    PROCESS.has_wall_clock = True


def get_rostime_cond() -> threading.Condition:
    """Return a condition that is notified when simulated time changes and when the node shuts down."""
    with _rostime_cond:
        if not _notifications_started:
            _notifications_started.append(True)
            PROCESS.add_start_callback(_start_notifications)
    return _rostime_cond


def _start_notifications(node: Any) -> None:
    PROCESS.on_shutdown(_notify_waiters, "after")
    if node.simulated_time:
        from pyros1.msgs.rosgraph_msgs.msg import Clock

        node.subscribe("/clock", Clock, _notify_waiters, queue_size=1)


def _notify_waiters(_: object) -> None:
    with _rostime_cond:
        _rostime_cond.notify_all()


def wallsleep(duration: float) -> None:
    """Sleep for a number of seconds of wall time."""
    if duration > 0:
        time.sleep(duration)


def _simulated_time() -> Any:
    """Return the simulated time; None with wall time, like stock's variable."""
    return None if is_wallclock() else get_rostime()


__getattr__, __dir__ = _module_hooks(
    __name__,
    computed_values={"_rostime_current": _simulated_time, "_rostime_initialized": is_rostime_initialized},
)
