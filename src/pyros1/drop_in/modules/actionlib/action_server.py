"""Server of an action with any number of goals (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rospy

from actionlib.action_client import message_classes
from actionlib.exceptions import ActionException
from actionlib.goal_id_generator import GoalIDGenerator
from actionlib.handle_tracker_deleter import HandleTrackerDeleter
from actionlib.server_goal_handle import ServerGoalHandle
from actionlib.status_tracker import StatusTracker
from pyros1.actions.goal_table import TOO_OLD_TEXT, GoalTable
from pyros1.actions.states import Status
from pyros1.drop_in.module_attributes import module_getattr
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
    "threading",
]

__getattr__ = module_getattr("actionlib.action_server")


def nop_cb(goal_handle: Any) -> None:
    """Ignore a request to cancel a goal."""


class ActionServer:
    """Receives goals, and reports their status to clients. ``lock`` is held during callbacks, so they do not overlap.

    Parameters: ``actionlib_server_pub_queue_size`` (50), ``actionlib_server_sub_queue_size`` (no limit),
    ``actionlib_status_frequency`` (5.0 Hz), and ``NS/status_list_timeout`` (5.0 s): how long the status of a goal is
    still published after it has finished.

    Args:
        ns: name of the action.
        ActionSpec: class of the action, such as TestAction.
        goal_cb: called with a `ServerGoalHandle` of each new goal, which must be accepted or rejected then or later.
        cancel_cb: called with a handle of each goal that a client asks to cancel.
        auto_start: whether to `start` immediately; then goals may arrive before the constructor returns.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
        AssertionError: ``goal_cb`` is None.
    """

    def __init__(
        self,
        ns: str,
        ActionSpec: Any,
        goal_cb: Callable[[Any], object],
        cancel_cb: Callable[[Any], object] = nop_cb,
        auto_start: bool = True,
    ) -> None:
        self.ns = ns
        self.ActionSpec = ActionSpec
        self.ActionGoal, self.ActionResult, self.ActionFeedback = message_classes(ActionSpec)
        assert goal_cb is not None
        self.ActionResultType = type(self.ActionResult().result)
        self.lock = threading.RLock()
        self.goal_callback = goal_cb
        self.cancel_callback = cancel_cb
        self.auto_start = auto_start
        self.started = False
        self.id_generator = GoalIDGenerator()
        self._table: GoalTable[StatusTracker] = GoalTable(rospy.Duration())
        self.status_pub: Any = None
        self.result_pub: Any = None
        self.feedback_pub: Any = None
        self.goal_sub: Any = None
        self.cancel_sub: Any = None
        self.status_timer: Any = None
        if auto_start:
            rospy.logwarn(
                "You've passed in true for auto_start to the python action server, you should always pass in false to "
                "avoid race conditions."
            )
            self.start()

    @property
    def status_list(self) -> list[StatusTracker]:
        """The goals, in the order in which they were received."""
        return self._table.goals

    @property
    def status_list_timeout(self) -> Any:
        """The rospy.Duration for which the status of a goal is published after it has finished."""
        return self._table.keep_duration

    @status_list_timeout.setter
    def status_list_timeout(self, timeout: Any) -> None:
        self._table.keep_duration = timeout

    @property
    def last_cancel(self) -> Any:
        """The latest rospy.Time up to which goals were cancelled by stamp."""
        return self._table.last_cancel

    @last_cancel.setter
    def last_cancel(self, time: Any) -> None:
        self._table.last_cancel = time

    def register_goal_callback(self, cb: Callable[[Any], object]) -> None:
        """Set the function to call with a handle of each new goal."""
        self.goal_callback = cb

    def register_cancel_callback(self, cancel_cb: Callable[[Any], object]) -> None:
        """Set the function to call with a handle of each goal that a client asks to cancel."""
        self.cancel_callback = cancel_cb

    def start(self) -> None:
        """Create the topics, so that goals can be received."""
        with self.lock:
            self.initialize()
            self.started = True
            self.publish_status()

    def stop(self) -> None:
        """Unregister all topics."""
        with self.lock:
            self.started = False
            self.status_timer.shutdown()
            for topic in (self.goal_sub, self.cancel_sub, self.status_pub, self.feedback_pub, self.result_pub):
                topic.unregister()

    def initialize(self) -> None:
        """Create the topics and the timer; called by `start`."""
        self.pub_queue_size = size = rospy.get_param("actionlib_server_pub_queue_size", 50)
        if size < 0:
            self.pub_queue_size = size = 50
        ns = rospy.remap_name(self.ns)
        self.status_pub = rospy.Publisher(f"{ns}/status", GoalStatusArray, latch=True, queue_size=size)
        self.result_pub = rospy.Publisher(f"{ns}/result", self.ActionResult, queue_size=size)
        self.feedback_pub = rospy.Publisher(f"{ns}/feedback", self.ActionFeedback, queue_size=size)
        size = rospy.get_param("actionlib_server_sub_queue_size", -1)
        self.sub_queue_size = size = None if size < 0 else size
        self.goal_sub = rospy.Subscriber(
            f"{ns}/goal", self.ActionGoal, callback=self.internal_goal_callback, queue_size=size
        )
        self.cancel_sub = rospy.Subscriber(
            f"{ns}/cancel", GoalID, callback=self.internal_cancel_callback, queue_size=size
        )
        if rospy.has_param(f"{ns}/status_frequency"):
            self.status_frequency = rospy.get_param(f"{ns}/status_frequency")
            rospy.logwarn(
                "You're using the deprecated status_frequency parameter, please switch to actionlib_status_frequency."
            )
        else:
            parameter = rospy.search_param("actionlib_status_frequency")
            self.status_frequency = 5.0 if parameter is None else rospy.get_param(parameter, 5.0)
        self.status_list_timeout = rospy.Duration(rospy.get_param(f"{ns}/status_list_timeout", 5.0))
        if self.status_frequency > 0.0:
            period = rospy.Duration(1.0 / self.status_frequency)
            self.status_timer = rospy.Timer(period, self.publish_status_async)

    # Messages to clients ----------------------------------------------------------------------------------------------

    def publish_result(self, status: Any, result: Any) -> None:
        """Send a goal's result message, with its GoalStatus, and the status of all goals."""
        with self.lock:
            message = self.ActionResult(status=status, result=result)
            message.header.stamp = rospy.Time.now()
            if not rospy.is_shutdown():
                self.result_pub.publish(message)
                self.publish_status()

    def publish_feedback(self, status: Any, feedback: Any) -> None:
        """Send a goal's feedback message, with its GoalStatus."""
        with self.lock:
            message = self.ActionFeedback(status=status)
            message.feedback = feedback  # publishing None raises an error
            message.header.stamp = rospy.Time.now()
            if not rospy.is_shutdown():
                self.feedback_pub.publish(message)

    def publish_status(self) -> None:
        """Send the status of all goals, and remove goals that finished more than ``status_list_timeout`` ago."""
        with self.lock:
            now = rospy.Time.now()
            for removed in self._table.forget(now):
                rospy.logdebug(
                    "Item %s with destruction time of %.3f being removed from list.  Now = %.3f",
                    removed.status.goal_id,
                    removed.handle_destruction_time.to_sec(),
                    now.to_sec(),
                )
            message = GoalStatusArray(status_list=[tracker.status for tracker in self.status_list])
            message.header.stamp = now
            if not rospy.is_shutdown():
                self.status_pub.publish(message)

    def publish_status_async(self, event: Any) -> None:
        """Send the status of all goals if the server has been started. This is the timer's callback."""
        with self.lock:
            if self.started:
                self.publish_status()

    # Messages from clients --------------------------------------------------------------------------------------------

    def internal_goal_callback(self, goal: Any) -> None:
        """Handle a message on the goal topic."""
        with self.lock:
            if not self.started:
                return
            rospy.logdebug("The action server has received a new goal request")
            known_tracker = self._table.find(goal.goal_id.id)
            if known_tracker is not None:
                self._handle_repeated_goal(known_tracker)
                return
            tracker = StatusTracker(goal=goal)
            self.status_list.append(tracker)
            handle = self._make_handle(tracker)
            if self._table.is_too_old(goal.goal_id):
                handle.set_canceled(None, TOO_OLD_TEXT)
            else:
                self.goal_callback(handle)

    def internal_cancel_callback(self, goal_id: Any) -> None:
        """Handle a message on the cancel topic, which cancels the goal with an id, all goals up to a time, or both.

        A message with neither cancels all goals.
        """
        with self.lock:
            if not self.started:
                return
            rospy.logdebug("The action server has received a new cancel request")
            for tracker in self._table.match_cancel(goal_id):
                if tracker.handle_tracker is None:
                    tracker.handle_destruction_time = rospy.Time.now()
                handle = self._make_handle(tracker)
                if handle.set_cancel_requested():
                    self.cancel_callback(handle)
            if goal_id.id and self._table.find(goal_id.id) is None:  # the goal may still arrive
                early_cancel = StatusTracker(goal_id, GoalStatus.RECALLING)
                early_cancel.handle_destruction_time = rospy.Time.now()
                self.status_list.append(early_cancel)

    def _make_handle(self, tracker: StatusTracker) -> ServerGoalHandle:
        if tracker.handle_tracker is None:
            tracker.handle_tracker = HandleTrackerDeleter(self, tracker)
        return ServerGoalHandle(tracker, self, tracker.handle_tracker)

    def _handle_repeated_goal(self, tracker: StatusTracker) -> None:
        """Handle a goal that was already received, or whose cancellation was requested before."""
        status = tracker.status
        rospy.logdebug("Goal %s was already in the status list with status %i", status.goal_id.id, status.status)
        if status.status == Status.RECALLING:
            status.status = GoalStatus.RECALLED
            self.publish_result(status, self.ActionResultType())
        if tracker.handle_tracker is None:
            tracker.handle_destruction_time = rospy.Time.now()
