"""Action server that executes one goal at a time, always the newest (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from typing import Any

import rospy

from actionlib.action_server import ActionServer, nop_cb
from actionlib.server_goal_handle import ServerGoalHandle
from pyros1.actions.simple_server import REPLACED_TEXT
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.actionlib_msgs.msg import GoalStatus

__all__ = [
    "ActionServer",
    "GoalStatus",
    "ServerGoalHandle",
    "SimpleActionServer",
    "nop_cb",
    "rospy",
    "threading",
    "traceback",
]

__getattr__ = module_getattr("actionlib.simple_action_server")

_POLL_INTERVAL = 0.1
"""Seconds between checks of whether the node has shut down."""
_EXIT_TIMEOUT = 5.0
"""Maximum number of seconds to wait for the thread that executes goals to exit."""


class SimpleActionServer:
    """Executes one goal at a time: a new goal preempts the current one, and replaces one that is waiting.

    A program passes ``execute_cb``, or calls `accept_new_goal` when its goal callback reports a new goal.

    Args:
        name: name of the action.
        ActionSpec: class of the action, such as TestAction.
        execute_cb: called with each goal message, such as TestGoal, in a separate thread. It must finish the goal with
            `set_succeeded`, `set_aborted` or `set_preempted`; otherwise the goal is aborted.
        auto_start: whether to `start` immediately; then goals may arrive before the constructor returns.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(
        self, name: str, ActionSpec: Any, execute_cb: Callable[[Any], object] | None = None, auto_start: bool = True
    ) -> None:
        self.new_goal = False
        self.preempt_request = False
        self.new_goal_preempt_request = False
        self.execute_callback = execute_cb
        self.goal_callback: Callable[[], object] | None = None
        self.preempt_callback: Callable[[], object] | None = None
        self.need_to_terminate = False
        self.terminate_mutex = threading.RLock()
        self.lock = threading.RLock()
        self.execute_condition = threading.Condition(self.lock)
        self.current_goal = ServerGoalHandle()
        self.next_goal = ServerGoalHandle()
        self.execute_thread: threading.Thread | None = None
        self.action_server = ActionServer(
            name, ActionSpec, self.internal_goal_callback, self.internal_preempt_callback, auto_start
        )
        if execute_cb:
            self.execute_thread = threading.Thread(target=self.executeLoop)
            self.execute_thread.start()

    def __del__(self) -> None:
        thread = getattr(self, "execute_thread", None)
        if thread is None:
            return
        with self.terminate_mutex:
            self.need_to_terminate = True
        if thread is not threading.current_thread():
            thread.join(_EXIT_TIMEOUT)

    def start(self) -> None:
        """Create the topics, so that goals can be received."""
        self.action_server.start()

    def register_goal_callback(self, cb: Callable[[], object] | None) -> None:
        """Set a function to call, without arguments, when a goal arrives; not for a server with ``execute_cb``."""
        if self.execute_callback:
            rospy.logwarn(
                "Cannot call SimpleActionServer.register_goal_callback() because an executeCallback exists. Not going "
                "to register it."
            )
        else:
            self.goal_callback = cb

    def register_preempt_callback(self, cb: Callable[[], object] | None) -> None:
        """Set a function to call, without arguments, when the current goal is preempted."""
        self.preempt_callback = cb

    # The current goal -------------------------------------------------------------------------------------------------

    def accept_new_goal(self) -> Any:
        """Start the goal that is waiting; the current one is cancelled if it has not finished.

        Returns:
            The goal message, such as TestGoal; None, with an error in the log, if no goal is waiting.
        """
        with self.action_server.lock, self.lock:
            if not self.new_goal or not self.next_goal.get_goal():
                rospy.logerr("Attempting to accept the next goal when a new goal is not available")
                return None
            if self.is_active() and self.current_goal != self.next_goal:
                self.current_goal.set_canceled(None, REPLACED_TEXT)
            rospy.logdebug("Accepting a new goal")
            self.current_goal = self.next_goal
            self.new_goal = False
            self.preempt_request, self.new_goal_preempt_request = self.new_goal_preempt_request, False
            self.current_goal.set_accepted("This goal has been accepted by the simple action server")
            return self.current_goal.get_goal()

    def is_new_goal_available(self) -> bool:
        """Return whether a goal is waiting."""
        return self.new_goal

    def is_preempt_requested(self) -> bool:
        """Return whether a client has cancelled the current goal, or a newer goal preempts it."""
        return self.preempt_request

    def is_active(self) -> bool:
        """Return whether there is a current goal that has not finished."""
        if not self.current_goal.get_goal():
            return False
        return self.current_goal.get_goal_status().status in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)

    def get_default_result(self) -> Any:
        """Return a result message of the action, with default values."""
        return self.action_server.ActionResultType()

    def publish_feedback(self, feedback: Any) -> None:
        """Send the action's feedback message, such as TestFeedback, for the current goal."""
        self.current_goal.publish_feedback(feedback)

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """Finish the current goal as succeeded.

        Args:
            result: the action's result message, such as TestResult; None for one with default values.
            text: a human-readable text.
        """
        with self.action_server.lock, self.lock:
            self.current_goal.set_succeeded(result or self.get_default_result(), text)

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """Finish the current goal as aborted."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_aborted(result or self.get_default_result(), text)

    def set_preempted(self, result: Any = None, text: str = "") -> None:
        """Finish the current goal as preempted."""
        with self.action_server.lock, self.lock:
            rospy.logdebug("Setting the current goal as canceled")
            self.current_goal.set_canceled(result or self.get_default_result(), text)

    # Called by the underlying server ----------------------------------------------------------------------------------

    def internal_goal_callback(self, goal: Any) -> None:
        """Handle a new goal: it waits to be accepted, unless it is older than a goal that was received before."""
        with self.action_server.lock, self.lock:
            try:
                self._queue_goal(goal)
            except Exception as error:  # noqa: BLE001 - raised by the program's callbacks
                rospy.logerr("SimpleActionServer.internal_goal_callback - exception %s", error)

    def _queue_goal(self, goal: Any) -> None:
        rospy.logdebug("A new goal %s has been received by the single goal action server", goal.get_goal_id().id)
        earlier_goals = [earlier for earlier in (self.current_goal, self.next_goal) if earlier.get_goal()]
        if earlier_goals and goal.get_goal_id().stamp < max(earlier.get_goal_id().stamp for earlier in earlier_goals):
            goal.set_canceled(None, REPLACED_TEXT)
            return
        if self.next_goal.get_goal() and self.next_goal != self.current_goal:
            self.next_goal.set_canceled(None, REPLACED_TEXT)
        self.next_goal = goal
        self.new_goal = True
        self.new_goal_preempt_request = False
        if self.is_active():
            self.preempt_request = True
            if self.preempt_callback:
                self.preempt_callback()
        if self.goal_callback:
            self.goal_callback()
        self.execute_condition.notify()

    def internal_preempt_callback(self, preempt: Any) -> None:
        """Handle a request to cancel the current goal, or the waiting goal."""
        with self.action_server.lock, self.lock:
            rospy.logdebug("A preempt has been received by the SimpleActionServer")
            if preempt == self.current_goal:
                rospy.logdebug("Setting preempt_request bit for the current goal to TRUE and invoking callback")
                self.preempt_request = True
                if self.preempt_callback:
                    self.preempt_callback()
            elif preempt == self.next_goal:
                rospy.logdebug("Setting preempt request bit for the next goal to TRUE")
                self.new_goal_preempt_request = True

    # Executing --------------------------------------------------------------------------------------------------------

    def executeLoop(self) -> None:
        """Call ``execute_cb`` for one goal after another until the node shuts down; runs in ``execute_thread``."""
        while not rospy.is_shutdown():
            with self.terminate_mutex:
                if self.need_to_terminate:
                    return
            if self.is_active():
                rospy.logerr("Should never reach this code with an active goal")
            elif self.is_new_goal_available():
                self._execute(self.accept_new_goal())
            with self.execute_condition:
                if not self.new_goal:
                    self.execute_condition.wait(_POLL_INTERVAL)

    def _execute(self, goal: Any) -> None:
        if not self.execute_callback:
            rospy.logerr("execute_callback must exist. This is a bug in SimpleActionServer")
            return
        try:
            self.execute_callback(goal)
        except Exception as error:  # noqa: BLE001 - raised by the program
            rospy.logerr("Exception in your execute callback: %s\n%s", error, traceback.format_exc())
            self.set_aborted(None, f"Exception in execute callback: {error}")
            return
        if self.is_active():
            rospy.logwarn(
                "Your executeCallback did not set the goal to a terminal status.  This is a bug in your ActionServer "
                "implementation. Fix your code!  For now, the ActionServer will set this goal to aborted"
            )
            self.set_aborted(None, "No terminal state was set.")
