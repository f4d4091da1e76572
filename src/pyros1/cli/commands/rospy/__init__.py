"""``pyros1 rospy``: makes rospy and the other ROS modules available to all programs in this Python environment."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "rospy",
    "make rospy and the other ROS modules available to all programs of this Python environment",
    group="machine",
    order=("enable", "disable", "status"),
)
