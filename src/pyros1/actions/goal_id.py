"""Creates goal names, and determines which goals a cancel request is for."""

from __future__ import annotations

import itertools
from typing import Any

from pyros1.ground.timing import Time


class GoalNames:
    """Creates goal names that are unique in the whole ROS system.

    Args:
        node_name: the node's full name.
    """

    def __init__(self, node_name: str) -> None:
        self._node_name = node_name
        self._counter = itertools.count(1)

    def next(self, now: Time) -> str:
        """Return a new name, such as ``/node-1-1700000000.123``."""
        return f"{self._node_name}-{next(self._counter)}-{now.secs}.{now.nsecs // 1_000_000:03}"


def cancel_request_matches(request: Any, goal_id: Any) -> bool:
    """Return whether a cancel request matches a goal.

    Args:
        request: an actionlib_msgs/GoalID with a name, a time (for all goals up to that time), both, or neither (for all
            goals).
        goal_id: the goal's actionlib_msgs/GoalID.
    """
    if request.id == goal_id.id:
        return True
    if request.stamp:
        return bool(goal_id.stamp <= request.stamp)
    return not request.id
