"""Client of an action, for any number of goals at once."""

from __future__ import annotations

import time
from typing import Any

import rospy
from rospy import Header

from actionlib.comm_state import (
    INVALID_TRANSITION,
    NO_TRANSITION,
    ClientGoalHandle,
    CommState,
    CommStateMachine,
    TerminalState,
    get_name_of_constant,
)
from actionlib.exceptions import ActionException
from actionlib.goal_manager import GoalManager
from pyros1.drop_in.missing import missing
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

__all__ = [
    "INVALID_TRANSITION",
    "NO_TRANSITION",
    "ActionClient",
    "ActionException",
    "ClientGoalHandle",
    "CommState",
    "CommStateMachine",
    "GoalID",
    "GoalManager",
    "GoalStatus",
    "GoalStatusArray",
    "Header",
    "TerminalState",
    "get_name_of_constant",
    "rospy",
]

__getattr__ = missing("actionlib.action_client", g_goal_id="goals get their numbers from a counter")


class ActionClient:
    """Sends goals, and follows them.

    Args:
        ns: name of the action.
        ActionSpec: class of the action, as TestAction.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        self.ns = ns
        self.last_status_msg: Any = None
        self.manager = GoalManager(ActionSpec)
        self.ActionSpec = ActionSpec
        self.ActionGoal = self.manager.ActionGoal
        self.ActionResult = self.manager.ActionResult
        self.ActionFeedback = self.manager.ActionFeedback
        name = rospy.remap_name(ns)
        size = rospy.get_param("actionlib_client_pub_queue_size", 10)
        self.pub_queue_size = size if size >= 0 else 10
        self.pub_goal = rospy.Publisher(f"{name}/goal", self.ActionGoal, queue_size=self.pub_queue_size)
        self.pub_cancel = rospy.Publisher(f"{name}/cancel", GoalID, queue_size=self.pub_queue_size)
        self.manager.register_send_goal_fn(self.pub_goal.publish)
        self.manager.register_cancel_fn(self.pub_cancel.publish)
        size = rospy.get_param("actionlib_client_sub_queue_size", -1)
        self.sub_queue_size = size if size >= 0 else None
        options: dict[str, Any] = {"queue_size": self.sub_queue_size}
        self.status_sub = rospy.Subscriber(f"{name}/status", GoalStatusArray, self._status_cb, **options)
        self.result_sub = rospy.Subscriber(f"{name}/result", self.ActionResult, self._result_cb, **options)
        self.feedback_sub = rospy.Subscriber(f"{name}/feedback", self.ActionFeedback, self._feedback_cb, **options)

    def stop(self) -> None:
        """End all topics."""
        for topic in (self.pub_goal, self.pub_cancel, self.status_sub, self.result_sub, self.feedback_sub):
            topic.unregister()

    def send_goal(self, goal: Any, transition_cb: Any = None, feedback_cb: Any = None) -> ClientGoalHandle:
        """Send a goal.

        Args:
            goal: the action's goal message, as TestGoal.
            transition_cb: called with the handle at each change of its state.
            feedback_cb: called with the handle and each feedback message.
        """
        return self.manager.init_goal(goal, transition_cb, feedback_cb)

    def cancel_all_goals(self) -> None:
        """Ask the server to cancel all its goals."""
        self.pub_cancel.publish(GoalID(stamp=rospy.Time(), id=""))

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to cancel all goals that were sent until a time."""
        self.pub_cancel.publish(GoalID(stamp=time, id=""))

    def wait_for_action_server_to_start(self, timeout: Any = rospy.Duration(0.0)) -> bool:  # noqa: B008
        """Old name of `wait_for_server`."""
        return self.wait_for_server(timeout)

    def wait_for_server(self, timeout: Any = rospy.Duration(0.0)) -> bool:  # noqa: B008
        """Wait until the server is connected on all topics.

        Args:
            timeout: a Duration; 0 for no limit.

        Returns:
            Whether it is connected.
        """
        ends = rospy.get_rostime() + timeout
        while not rospy.is_shutdown():
            if self._is_connected():
                return True
            if timeout != rospy.Duration(0.0) and rospy.get_rostime() >= ends:
                break
            time.sleep(0.01)
        return False

    def _is_connected(self) -> bool:
        topics = (self.pub_goal, self.pub_cancel, self.result_sub, self.feedback_sub)
        return self.last_status_msg is not None and all(topic.get_num_connections() for topic in topics)

    def _status_cb(self, msg: Any) -> None:
        self.last_status_msg = msg
        self.manager.update_statuses(msg)

    def _result_cb(self, msg: Any) -> None:
        self.manager.update_results(msg)

    def _feedback_cb(self, msg: Any) -> None:
        self.manager.update_feedbacks(msg)
