"""Time of the node, and sleeping (https://wiki.ros.org/rospy/Overview/Time)."""

from __future__ import annotations

import time
from typing import Any

import pyros1.ground.timing
from pyros1.drop_in.process import PROCESS
from rospy.exceptions import ROSInitException

Duration = pyros1.ground.timing.Duration


class Time(pyros1.ground.timing.Time):
    """A point in time."""

    __slots__ = ()

    @staticmethod
    def now() -> Time:
        """Return the current time.

        Raises:
            ROSInitException: the node has not been started.
        """
        return get_rostime()


def _node() -> Any:
    if PROCESS.node is None:
        raise ROSInitException("time is not initialized. Have you called init_node()?")
    return PROCESS.node


def get_rostime() -> Time:
    """Return the node's time; raises ROSInitException without a node."""
    now = _node().now()
    return Time(now.secs, now.nsecs)


def get_time() -> float:
    """Return the node's time in seconds; raises ROSInitException without a node."""
    seconds: float = _node().now().to_sec()
    return seconds


def is_wallclock() -> bool:
    """Return whether the node uses wall time."""
    return PROCESS.node is None or not PROCESS.node.simulated_time


def wallsleep(duration: float) -> None:
    """Sleep for some seconds of wall time."""
    if duration >= 0:
        time.sleep(duration)
