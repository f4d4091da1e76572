"""Client of an action with any number of goals (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

import threading
import time
import weakref
from collections.abc import Callable
from math import inf
from typing import Any

import rospy

from actionlib.comm_state import (
    ClientGoalHandle,
    CommState,
    CommStateMachine,
    TerminalState,
    get_name_of_constant,
)
from actionlib.exceptions import ActionException
from pyros1.actions import ActionError
from pyros1.actions.messages import ActionTypes
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.drop_in.process import PROCESS
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from pyros1.msgs.std_msgs.msg import Header
from pyros1.node.clock import TICK_TIMEOUT

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
    "g_goal_id",
    "get_name_of_constant",
    "rospy",
    "threading",
    "time",
    "weakref",
]

__getattr__ = module_getattr(
    "actionlib.action_client",
    _transitions="see pyros1.actions.states.stages_after",
    _find_status_by_goal_id="look into status_array.status_list",
)

NO_TRANSITION = -1
INVALID_TRANSITION = -2
g_goal_id = 1
"""The number that the program's next goal gets."""
_goal_id_lock = threading.RLock()
_POLL_INTERVAL = 0.01
"""Seconds between checks for the server."""


def message_classes(ActionSpec: Any) -> tuple[Any, Any, Any]:
    """Return the classes of an action's goal, result and feedback messages; raise ActionException if the class is not
    an action.
    """
    example = ActionSpec()
    try:
        types = ActionTypes.of(type(example))
    except ActionError:
        raise ActionException(f"Type is not an action spec: {ActionSpec}") from None
    return types.action_goal, types.action_result, types.action_feedback


class Countdown:
    """A timeout in the node's time, which may jump back, or stand still while the node shuts down.

    Args:
        timeout: rospy.Duration; zero for no limit.
    """

    def __init__(self, timeout: Any) -> None:
        self._last = rospy.get_rostime()
        self._seconds_left = (
            (self._last + timeout) - self._last
        ).to_sec() or inf  # like stock, raises an error for types other than Duration
        self._last_change = time.monotonic()

    def seconds_left(self) -> float:
        """Return the remaining seconds."""
        now = rospy.get_rostime()
        if now != self._last:
            self._seconds_left -= max(0.0, (now - self._last).to_sec())
            self._last, self._last_change = now, time.monotonic()
        elif PROCESS.shutdown_requested and time.monotonic() - self._last_change > TICK_TIMEOUT:
            return 0.0  # in a shutdown hook: the simulation that publishes /clock has ended, too
        return self._seconds_left


class GoalManager:
    """A client's goals. The manager only holds weak references to them: goals without handles are removed.

    Args:
        ActionSpec: class of the action, such as TestAction.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(self, ActionSpec: Any) -> None:
        self.list_mutex = threading.RLock()
        self.statuses: list[weakref.ref[CommStateMachine]] = []
        self.send_goal_fn: Any = None
        self.ActionSpec = ActionSpec
        self.ActionGoal, self.ActionResult, self.ActionFeedback = message_classes(ActionSpec)

    def register_send_goal_fn(self, fn: Callable[[Any], object]) -> None:
        """Set the function that sends a goal's message."""
        self.send_goal_fn = fn

    def register_cancel_fn(self, fn: Callable[[Any], object]) -> None:
        """Set the function that sends a goal's GoalID to cancel the goal."""
        self.cancel_fn = fn

    def init_goal(
        self,
        goal: Any,
        transition_cb: Callable[[Any], object] | None = None,
        feedback_cb: Callable[[Any, Any], object] | None = None,
    ) -> ClientGoalHandle:
        """Send a goal, such as TestGoal; see `ActionClient.send_goal`."""
        message = self.ActionGoal(header=Header(stamp=rospy.Time.now()), goal_id=self._generate_id(), goal=goal)
        machine = CommStateMachine(message, transition_cb, feedback_cb, self.send_goal_fn, self.cancel_fn)
        with self.list_mutex:
            self.statuses.append(weakref.ref(machine))
        self.send_goal_fn(message)
        return ClientGoalHandle(machine)

    def update_statuses(self, status_array: Any) -> None:
        """Pass a message on the action's status topic to all goals."""
        for machine in self._get_live_statuses():
            machine.update_status(status_array)

    def update_results(self, action_result: Any) -> None:
        """Pass a message on the action's result topic to all goals."""
        for machine in self._get_live_statuses():
            machine.update_result(action_result)

    def update_feedbacks(self, action_feedback: Any) -> None:
        """Pass a message on the action's feedback topic to all goals."""
        for machine in self._get_live_statuses():
            machine.update_feedback(action_feedback)

    def _generate_id(self) -> Any:
        global g_goal_id
        with _goal_id_lock:
            number, g_goal_id = g_goal_id, g_goal_id + 1
        now = rospy.Time.now()
        return GoalID(stamp=now, id=f"{rospy.get_name()}-{number}-{now.to_sec():.3f}")

    def _get_live_statuses(self) -> list[CommStateMachine]:
        with self.list_mutex:
            machines = [machine for machine in (reference() for reference in self.statuses) if machine is not None]
            if len(machines) < len(self.statuses):
                self.statuses = [reference for reference in self.statuses if reference() is not None]
        return machines


class ActionClient:
    """Sends goals to an action's server, and tracks all of them.

    Parameters: ``actionlib_client_pub_queue_size`` (10) and ``actionlib_client_sub_queue_size`` (no limit).

    Args:
        ns: name of the action.
        ActionSpec: class of the action, such as TestAction.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        self.ns = ns
        self.last_status_msg: Any = None
        self.ActionSpec = ActionSpec
        self.ActionGoal, self.ActionResult, self.ActionFeedback = message_classes(ActionSpec)
        ns = rospy.remap_name(ns)
        size = rospy.get_param("actionlib_client_pub_queue_size", 10)
        self.pub_queue_size = 10 if size < 0 else size
        self.pub_goal = rospy.Publisher(f"{ns}/goal", self.ActionGoal, queue_size=self.pub_queue_size)
        self.pub_cancel = rospy.Publisher(f"{ns}/cancel", GoalID, queue_size=self.pub_queue_size)
        self.manager = GoalManager(ActionSpec)
        self.manager.register_send_goal_fn(self.pub_goal.publish)
        self.manager.register_cancel_fn(self.pub_cancel.publish)
        size = rospy.get_param("actionlib_client_sub_queue_size", -1)
        self.sub_queue_size = None if size < 0 else size
        topics = (
            ("status", GoalStatusArray, self._status_cb),
            ("result", self.ActionResult, self._result_cb),
            ("feedback", self.ActionFeedback, self._feedback_cb),
        )
        self.status_sub, self.result_sub, self.feedback_sub = (
            rospy.Subscriber(f"{ns}/{topic}", message_class, callback=callback, queue_size=self.sub_queue_size)
            for topic, message_class, callback in topics
        )

    def stop(self) -> None:
        """Unregister all topics, so that goals are no longer updated."""
        for topic in (self.pub_goal, self.pub_cancel, self.status_sub, self.result_sub, self.feedback_sub):
            topic.unregister()

    def send_goal(
        self,
        goal: Any,
        transition_cb: Callable[[Any], object] | None = None,
        feedback_cb: Callable[[Any, Any], object] | None = None,
    ) -> ClientGoalHandle:
        """Send a goal. The handle must be kept, since no callbacks are called without it.

        Args:
            goal: the action's goal message, such as TestGoal.
            transition_cb: called with a handle of the goal in each new CommState.
            feedback_cb: called with a handle of the goal and each feedback message, such as TestFeedback.
        """
        return self.manager.init_goal(goal, transition_cb, feedback_cb)

    def cancel_all_goals(self) -> None:
        """Ask the server to cancel all goals, including those of other clients."""
        self.pub_cancel.publish(GoalID(stamp=rospy.Time(), id=""))

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to cancel all goals sent at or before a rospy.Time, including those of other clients."""
        self.pub_cancel.publish(GoalID(stamp=time, id=""))

    def wait_for_server(self, timeout: Any = rospy.Duration()) -> bool:  # noqa: B008  stock's signature
        """Wait until the server is connected on all topics.

        Args:
            timeout: rospy.Duration; zero for no limit.

        Returns:
            Whether it is connected; False if the node shuts down before that.
        """
        countdown = Countdown(timeout)
        while not rospy.is_shutdown():
            if self._is_connected():
                return True
            if countdown.seconds_left() <= 0:
                return False
            time.sleep(_POLL_INTERVAL)
        return False

    def wait_for_action_server_to_start(self, timeout: Any = rospy.Duration()) -> bool:  # noqa: B008
        """Wait until the server is connected; the old name of `wait_for_server`."""
        return self.wait_for_server(timeout)

    def _is_connected(self) -> bool:
        status = self.last_status_msg
        if status is None:
            return False
        server = status._connection_header["callerid"]
        return all(topic.impl.has_connection(server) for topic in (self.pub_goal, self.pub_cancel)) and all(
            any(connection.callerid_pub == server for connection in topic.impl.connections)
            for topic in (self.result_sub, self.feedback_sub)
        )

    def _status_cb(self, msg: Any) -> None:
        self.last_status_msg = msg
        self.manager.update_statuses(msg)

    def _result_cb(self, msg: Any) -> None:
        self.manager.update_results(msg)

    def _feedback_cb(self, msg: Any) -> None:
        self.manager.update_feedbacks(msg)
