"""What a server knows about a goal."""

from __future__ import annotations

from typing import Any

import rospy

from actionlib import goal_id_generator
from pyros1.msgs.actionlib_msgs.msg import GoalStatus


class StatusTracker:
    """Status of a goal, made from a GoalID and a status, or from the message that brought the goal.

    Attributes:
        goal: that message; None if only a request to cancel it has come.
        status: the GoalStatus that is published.
        handle_tracker: the goal's HandleTrackerDeleter.
        handle_destruction_time: since when nobody holds the goal; 0 while someone does.
    """

    def __init__(self, goal_id: Any = None, status: Any = None, goal: Any = None) -> None:
        self.goal = None if goal_id else goal
        self.handle_tracker: Any = None
        self.handle_destruction_time = rospy.Time()
        self.id_generator = goal_id_generator.GoalIDGenerator()
        self.status: Any = GoalStatus()
        if goal_id:
            self.status.goal_id, self.status.status = goal_id, status
            return
        self.status.goal_id = goal.goal_id if goal.goal_id.id else self.id_generator.generate_ID()
        if not self.status.goal_id.stamp:
            self.status.goal_id.stamp = rospy.Time.now()
