"""Names for goals that came without one."""

from __future__ import annotations

import itertools
from typing import Any

import rospy

from pyros1.drop_in.missing import missing
from pyros1.msgs.actionlib_msgs.msg import GoalID

_numbers = itertools.count(1)


__getattr__ = missing(
    "actionlib.goal_id_generator",
    s_goalcount="goals get numbers without a lock",
    s_goalcount_lock="goals get numbers without a lock",
)


class GoalIDGenerator:
    """Makes names that begin with a node's.

    Args:
        name: full name of the node; None for this program's.
    """

    def __init__(self, name: str | None = None) -> None:
        self.set_name(rospy.get_name() if name is None else name)

    def set_name(self, name: str) -> None:
        """Set the name with which those of goals begin."""
        self.name = name

    def generate_ID(self) -> Any:
        """Return a new GoalID, with the present time."""
        now = rospy.Time.now()
        return GoalID(stamp=now, id=f"{self.name}-{next(_numbers)}-{now.secs}.{now.nsecs}")
