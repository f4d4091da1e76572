"""The goals of a client; stock has this class in actionlib.action_client."""

from __future__ import annotations

import itertools
import threading
import weakref
from typing import Any

import rospy

from actionlib.comm_state import ClientGoalHandle, CommStateMachine
from actionlib.exceptions import ActionException
from pyros1.msgs.actionlib_msgs.msg import GoalID

_numbers = itertools.count(1)


class GoalManager:
    """Follows the goals that have a handle left.

    Args:
        ActionSpec: class of the action.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(self, ActionSpec: Any) -> None:
        self.list_mutex = threading.RLock()
        self.statuses: list[weakref.ref[CommStateMachine]] = []
        self.send_goal_fn: Any = None
        self.cancel_fn: Any = None
        try:
            parts = ActionSpec()
            self.ActionSpec = ActionSpec
            self.ActionGoal: Any = type(parts.action_goal)
            self.ActionResult: Any = type(parts.action_result)
            self.ActionFeedback: Any = type(parts.action_feedback)
        except AttributeError:
            raise ActionException(f"Type is not an action spec: {ActionSpec!s}") from None

    def register_send_goal_fn(self, fn: Any) -> None:
        """Set what sends goals."""
        self.send_goal_fn = fn

    def register_cancel_fn(self, fn: Any) -> None:
        """Set what sends requests to cancel goals."""
        self.cancel_fn = fn

    def init_goal(self, goal: Any, transition_cb: Any = None, feedback_cb: Any = None) -> ClientGoalHandle:
        """Send a goal and follow it, as long as its handle lives."""
        message = self.ActionGoal(goal_id=self._generate_id(), goal=goal)
        message.header.stamp = rospy.get_rostime()
        machine = CommStateMachine(message, transition_cb, feedback_cb, self.send_goal_fn, self.cancel_fn)
        with self.list_mutex:
            self.statuses.append(weakref.ref(machine))
        self.send_goal_fn(message)
        return ClientGoalHandle(machine)

    def update_statuses(self, status_array: Any) -> None:
        """Take a GoalStatusArray."""
        with self.list_mutex:
            self.statuses = [each for each in self.statuses if each() is not None]
        for machine in self._get_live_statuses():
            machine.update_status(status_array)

    def update_results(self, action_result: Any) -> None:
        """Take a result."""
        for machine in self._get_live_statuses():
            machine.update_result(action_result)

    def update_feedbacks(self, action_feedback: Any) -> None:
        """Take feedback."""
        for machine in self._get_live_statuses():
            machine.update_feedback(action_feedback)

    def _get_live_statuses(self) -> list[CommStateMachine]:
        with self.list_mutex:
            return [machine for each in self.statuses if (machine := each()) is not None]

    @staticmethod
    def _generate_id() -> Any:
        now = rospy.Time.now()
        return GoalID(stamp=now, id=f"{rospy.get_caller_id()}-{next(_numbers)}-{now.to_sec():.3f}")
