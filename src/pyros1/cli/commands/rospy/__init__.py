"""``pyros1 rospy``: rospy and its siblings for all programs of this Python environment."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "rospy",
    "rospy and its siblings for all programs of this Python environment",
    group="machine",
    order=("enable", "disable", "status"),
)
