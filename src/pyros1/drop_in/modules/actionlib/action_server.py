"""Server of an action, for any number of goals at once."""

from __future__ import annotations

import threading
from typing import Any

import rospy

from actionlib.exceptions import ActionException
from actionlib.goal_id_generator import GoalIDGenerator
from actionlib.handle_tracker_deleter import HandleTrackerDeleter
from actionlib.server_goal_handle import ServerGoalHandle
from actionlib.status_tracker import StatusTracker
from pyros1.actions.goal_id import is_meant
from pyros1.actions.table import TOO_OLD
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

__all__ = [
    "ActionException",
    "ActionServer",
    "GoalID",
    "GoalIDGenerator",
    "GoalStatus",
    "GoalStatusArray",
    "HandleTrackerDeleter",
    "ServerGoalHandle",
    "StatusTracker",
    "nop_cb",
    "rospy",
]


def nop_cb(goal_handle: Any) -> None:
    """Do nothing."""


class ActionServer:
    """Receives goals, and tells clients how they are.

    Args:
        ns: name of the action.
        ActionSpec: class of the action, as TestAction.
        goal_cb: called with the ServerGoalHandle of each new goal.
        cancel_cb: called with that of each goal that a client asks to cancel.
        auto_start: begin at once; better call `start` when all is ready.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(
        self,
        ns: str,
        ActionSpec: Any,
        goal_cb: Any,
        cancel_cb: Any = nop_cb,
        auto_start: bool = True,
    ) -> None:
        self.ns = ns
        try:
            parts = ActionSpec()
            self.ActionSpec = ActionSpec
            self.ActionGoal = type(parts.action_goal)
            self.ActionResult = type(parts.action_result)
            self.ActionResultType = type(parts.action_result.result)
            self.ActionFeedback = type(parts.action_feedback)
        except AttributeError:
            raise ActionException(f"Type is not an action spec: {ActionSpec!s}") from None
        assert goal_cb
        self.goal_sub: Any = None
        self.cancel_sub: Any = None
        self.status_pub: Any = None
        self.result_pub: Any = None
        self.feedback_pub: Any = None
        self.status_timer: Any = None
        self.lock = threading.RLock()
        self.status_list: list[StatusTracker] = []
        self.last_cancel = rospy.Time()
        self.status_list_timeout = rospy.Duration()
        self.id_generator = GoalIDGenerator()
        self.goal_callback = goal_cb
        self.cancel_callback = cancel_cb
        self.auto_start = auto_start
        self.started = False
        if auto_start:
            rospy.logwarn(
                "You've passed in true for auto_start to the python action server, you should always pass in false to "
                "avoid race conditions."
            )
            self.start()

    def register_goal_callback(self, cb: Any) -> None:
        """Replace the callback for new goals."""
        self.goal_callback = cb

    def register_cancel_callback(self, cancel_cb: Any) -> None:
        """Replace the callback for goals that shall be cancelled."""
        self.cancel_callback = cancel_cb

    def start(self) -> None:
        """Begin: clients find the server."""
        with self.lock:
            self.initialize()
            self.started = True
            self.publish_status()

    def stop(self) -> None:
        """End; the goals should have ended before."""
        with self.lock:
            self.started = False
            for part in (self.goal_sub, self.cancel_sub, self.status_pub, self.feedback_pub, self.result_pub):
                part.unregister()
            if self.status_timer is not None:
                self.status_timer.shutdown()

    def initialize(self) -> None:
        """Make the topics and the timer."""
        name = rospy.remap_name(self.ns)
        size = rospy.get_param("actionlib_server_pub_queue_size", 50)
        self.pub_queue_size = size if size >= 0 else 50
        self.status_pub = rospy.Publisher(f"{name}/status", GoalStatusArray, latch=True, queue_size=self.pub_queue_size)
        self.result_pub = rospy.Publisher(f"{name}/result", self.ActionResult, queue_size=self.pub_queue_size)
        self.feedback_pub = rospy.Publisher(f"{name}/feedback", self.ActionFeedback, queue_size=self.pub_queue_size)
        size = rospy.get_param("actionlib_server_sub_queue_size", -1)
        self.sub_queue_size = size if size >= 0 else None
        self.goal_sub = rospy.Subscriber(
            f"{name}/goal", self.ActionGoal, self.internal_goal_callback, queue_size=self.sub_queue_size
        )
        self.cancel_sub = rospy.Subscriber(
            f"{name}/cancel", GoalID, self.internal_cancel_callback, queue_size=self.sub_queue_size
        )
        self.status_frequency = self._frequency(name)
        self.status_list_timeout = rospy.Duration(rospy.get_param(f"{name}/status_list_timeout", 5.0))
        if self.status_frequency > 0.0:
            self.status_timer = rospy.Timer(rospy.Duration(1.0 / self.status_frequency), self.publish_status_async)

    @staticmethod
    def _frequency(name: str) -> float:
        if rospy.has_param(f"{name}/status_frequency"):
            rospy.logwarn(
                "You're using the deprecated status_frequency parameter, please switch to actionlib_status_frequency."
            )
            return float(rospy.get_param(f"{name}/status_frequency", 5.0))
        nearest = rospy.search_param("actionlib_status_frequency")
        return 5.0 if nearest is None else float(rospy.get_param(nearest, 5.0))

    def publish_result(self, status: Any, result: Any) -> None:
        """Send the result of a goal, and the status of all."""
        with self.lock:
            message = self.ActionResult(status=status, result=result)
            message.header.stamp = rospy.Time.now()
            if not rospy.is_shutdown():
                self.result_pub.publish(message)
            self.publish_status()

    def publish_feedback(self, status: Any, feedback: Any) -> None:
        """Send how a goal goes on."""
        with self.lock:
            message = self.ActionFeedback(status=status, feedback=feedback)
            message.header.stamp = rospy.Time.now()
            if not rospy.is_shutdown():
                self.feedback_pub.publish(message)

    def internal_cancel_callback(self, goal_id: Any) -> None:
        """Take a client's request to cancel goals."""
        with self.lock:
            if not self.started:
                return
            rospy.logdebug("The action server has received a new cancel request")
            found = False
            for tracker in list(self.status_list):
                if not is_meant(goal_id, tracker.status.goal_id):
                    continue
                found = found or tracker.status.goal_id.id == goal_id.id
                if tracker.handle_tracker is None:
                    tracker.handle_tracker = HandleTrackerDeleter(self, tracker)
                    tracker.handle_destruction_time = rospy.Time.now()
                handle = ServerGoalHandle(tracker, self, tracker.handle_tracker)
                if handle.set_cancel_requested():
                    self.cancel_callback(handle)
            if goal_id.id and not found:  # the goal may still come
                tracker = StatusTracker(goal_id, GoalStatus.RECALLING)
                tracker.handle_destruction_time = rospy.Time.now()
                self.status_list.append(tracker)
            self.last_cancel = max(self.last_cancel, goal_id.stamp)

    def internal_goal_callback(self, goal: Any) -> None:
        """Take a client's goal."""
        with self.lock:
            if not self.started:
                return
            rospy.logdebug("The action server has received a new goal request")
            for tracker in self.status_list:
                if tracker.status.goal_id.id == goal.goal_id.id:
                    self._take_again(tracker)
                    return
            tracker = StatusTracker(None, None, goal)
            self.status_list.append(tracker)
            tracker.handle_tracker = HandleTrackerDeleter(self, tracker)
            handle = ServerGoalHandle(tracker, self, tracker.handle_tracker)
            if goal.goal_id.stamp and goal.goal_id.stamp <= self.last_cancel:
                handle.set_canceled(None, TOO_OLD)
            else:
                self.goal_callback(handle)

    def _take_again(self, tracker: StatusTracker) -> None:
        """Take a goal that is known, perhaps from a request to cancel it that came first."""
        status = tracker.status
        rospy.logdebug("Goal %s was already in the status list with status %i", status.goal_id.id, status.status)
        if status.status == GoalStatus.RECALLING:
            status.status = GoalStatus.RECALLED
            self.publish_result(status, self.ActionResultType())
        if tracker.handle_tracker is None:
            tracker.handle_destruction_time = rospy.Time.now()

    def publish_status_async(self, event: Any) -> None:
        """Send the status of all goals, unless the server has not been started."""
        with self.lock:
            if self.started:
                self.publish_status()

    def publish_status(self) -> None:
        """Send the status of all goals, and forget those that ended long ago."""
        with self.lock:
            now = rospy.Time.now()
            for tracker in list(self.status_list):
                gone = tracker.handle_destruction_time
                if gone and gone + self.status_list_timeout < now:
                    self.status_list.remove(tracker)
            message = GoalStatusArray(status_list=[tracker.status for tracker in self.status_list])
            message.header.stamp = now
            if not rospy.is_shutdown():
                self.status_pub.publish(message)
