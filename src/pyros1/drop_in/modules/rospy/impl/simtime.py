"""Simulated time; the node itself subscribes to /clock (https://wiki.ros.org/Clock)."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.drop_in.process import PROCESS
from rospy.rostime import _set_rostime, set_rostime_initialized

__all__ = ["init_simtime"]

_ROSCLOCK = "/clock"
_USE_SIMTIME = "/use_sim_time"


def init_simtime() -> bool:
    """Make wall time available without a node; return True."""
    set_rostime_initialized(True)
    return True


def _is_use_simtime() -> bool:
    return PROCESS.node is not None and PROCESS.node.simulated_time


def _set_rostime_clock_wrapper(time_msg: Any) -> None:
    """Set the time from a message on /clock."""
    _set_rostime(time_msg.clock)


__getattr__ = module_getattr("rospy.impl.simtime", _clock_sub="a node listens to /clock itself")
