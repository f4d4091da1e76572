"""Generates ids for goals without an id."""

from __future__ import annotations

import threading
from typing import Any

import rospy

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.actionlib_msgs.msg import GoalID

__all__ = [
    "GoalID",
    "GoalIDGenerator",
    "rospy",
    "s_goalcount",
    "s_goalcount_lock",
    "threading",
]

__getattr__ = module_getattr("actionlib.goal_id_generator")

s_goalcount_lock = threading.Lock()
s_goalcount = 0
"""Number of ids that this program has generated."""
_reentrant_lock = threading.RLock()  # a signal handler may generate an id as well; stock's lock would deadlock


class GoalIDGenerator:
    """Generates goal ids that start with a node's name.

    Args:
        name: full name of the node; None for this program's node.
    """

    def __init__(self, name: str | None = None) -> None:
        self.set_name(rospy.get_name() if name is None else name)

    def set_name(self, name: str) -> None:
        """Set the prefix of the generated ids."""
        self.name = name

    def generate_ID(self) -> Any:
        """Return a new GoalID, with the current time."""
        global s_goalcount  # noqa: PLW0603  stock's name for it
        now = rospy.Time.now()
        with _reentrant_lock:
            s_goalcount += 1
            number = s_goalcount
        return GoalID(stamp=now, id=f"{self.name}-{number}-{now.secs}.{now.nsecs}")
