"""A server's information about a goal."""

from __future__ import annotations

from typing import Any

import rospy

from actionlib import goal_id_generator
from pyros1.actions.goal_table import Tracked
from pyros1.drop_in.module_attributes import module_getattr

__all__ = [
    "StatusTracker",
    "goal_id_generator",
    "rospy",
]

__getattr__ = module_getattr("actionlib.status_tracker")


class StatusTracker(Tracked):
    """A goal that was received, or a request to cancel a goal that has not arrived yet.

    Attributes:
        status: the actionlib_msgs/GoalStatus.
        goal: the message on the action's goal topic, or None.
        handle_tracker: the `HandleTrackerDeleter` of the handles; None if there are none.
        handle_destruction_time: rospy.Time at which the last handle was deleted; zero while there are handles.

    Args:
        goal_id, status: the GoalID of a cancel request, and its status, a constant of GoalStatus; both None for a goal.
        goal: the goal's message; None for a cancel request. An empty id is replaced with a generated one, a zero stamp
            with the current time.
    """

    def __init__(self, goal_id: Any = None, status: int | None = None, goal: Any = None) -> None:
        self.id_generator = goal_id_generator.GoalIDGenerator()
        self.handle_tracker: Any = None
        if goal_id:
            super().__init__(goal_id)
            self.status.status = status
            return
        own_id = goal.goal_id if goal.goal_id.id else self.id_generator.generate_ID()
        if not own_id.stamp:
            own_id.stamp = rospy.Time.now()
        super().__init__(own_id, goal=goal)

    @property
    def handle_destruction_time(self) -> Any:
        """The rospy.Time at which the last handle was deleted; zero while there are handles."""
        return self.ended_at or rospy.Time()

    @handle_destruction_time.setter
    def handle_destruction_time(self, time: Any) -> None:
        self.ended_at = time or None
