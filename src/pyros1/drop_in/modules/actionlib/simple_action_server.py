"""Server of an action that works on one goal at a time: the newest."""

from __future__ import annotations

import threading
import traceback
from typing import Any

import rospy

from actionlib.action_server import ActionServer, nop_cb
from actionlib.server_goal_handle import ServerGoalHandle
from pyros1.actions.simple_server import REPLACED
from pyros1.msgs.actionlib_msgs.msg import GoalStatus

__all__ = ["ActionServer", "GoalStatus", "ServerGoalHandle", "SimpleActionServer", "nop_cb", "rospy"]


class SimpleActionServer:
    """Works on the newest goal: a new one asks the present one to stop, and takes the place of one that waits.

    Args:
        name: name of the action.
        ActionSpec: class of the action, as TestAction.
        execute_cb: called with each goal message in a thread of its own; it calls one of ``set_...`` at the end.
            Without it, the program asks `is_new_goal_available`, or registers a callback, and calls `accept_new_goal`.
        auto_start: begin at once; better call `start` when all is ready.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(self, name: str, ActionSpec: Any, execute_cb: Any = None, auto_start: bool = True) -> None:
        self.new_goal = False
        self.preempt_request = False
        self.new_goal_preempt_request = False
        self.execute_callback = execute_cb
        self.goal_callback: Any = None
        self.preempt_callback: Any = None
        self.need_to_terminate = False
        self.terminate_mutex = threading.RLock()
        self.lock = threading.RLock()  # always taken after the lock of the ActionServer
        self.execute_condition = threading.Condition(self.lock)
        self.current_goal = ServerGoalHandle()
        self.next_goal = ServerGoalHandle()
        self.execute_thread: threading.Thread | None = None
        if execute_cb:
            self.execute_thread = threading.Thread(target=self.executeLoop)
            self.execute_thread.start()
        self.action_server = ActionServer(
            name, ActionSpec, self.internal_goal_callback, self.internal_preempt_callback, auto_start
        )

    def __del__(self) -> None:
        thread = getattr(self, "execute_thread", None)
        if thread is not None:
            with self.terminate_mutex:
                self.need_to_terminate = True
            if thread is not threading.current_thread():
                thread.join()

    def start(self) -> None:
        """Begin: clients find the server."""
        self.action_server.start()

    def accept_new_goal(self) -> Any:
        """Begin with the goal that waits, and return it; one that is active ends as preempted. None if none waits."""
        with self.action_server.lock, self.lock:
            if not self.new_goal or self.next_goal.get_goal() is None:
                rospy.logerr("Attempting to accept the next goal when a new goal is not available")
                return None
            if self.is_active() and self.current_goal != self.next_goal:
                self.current_goal.set_canceled(None, REPLACED)
            rospy.logdebug("Accepting a new goal")
            self.current_goal = self.next_goal
            self.new_goal = False
            self.preempt_request, self.new_goal_preempt_request = self.new_goal_preempt_request, False
            self.current_goal.set_accepted("This goal has been accepted by the simple action server")
            return self.current_goal.get_goal()

    def is_new_goal_available(self) -> bool:
        """Return whether a goal waits."""
        return self.new_goal

    def is_preempt_requested(self) -> bool:
        """Return whether the present goal shall stop."""
        return self.preempt_request

    def is_active(self) -> bool:
        """Return whether there is a goal that has begun and not ended."""
        if self.current_goal.get_goal() is None:
            return False
        return self.current_goal.get_goal_status().status in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """End the goal: it was reached."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_succeeded(result or self.get_default_result(), text)

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """End the goal: it cannot be reached."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_aborted(result or self.get_default_result(), text)

    def set_preempted(self, result: Any = None, text: str = "") -> None:
        """End the goal: it was stopped."""
        with self.action_server.lock, self.lock:
            rospy.logdebug("Setting the current goal as canceled")
            self.current_goal.set_canceled(result or self.get_default_result(), text)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the clients."""
        self.current_goal.publish_feedback(feedback)

    def get_default_result(self) -> Any:
        """Return a result with default values."""
        return self.action_server.ActionResultType()

    def register_goal_callback(self, cb: Any) -> None:
        """Set what is called when a goal has come; not possible with ``execute_cb``."""
        if self.execute_callback:
            rospy.logwarn(
                "Cannot call SimpleActionServer.register_goal_callback() because an executeCallback exists. Not going "
                "to register it."
            )
        else:
            self.goal_callback = cb

    def register_preempt_callback(self, cb: Any) -> None:
        """Set what is called when the present goal shall stop."""
        self.preempt_callback = cb

    def internal_goal_callback(self, goal: ServerGoalHandle) -> None:
        """Take a new goal."""
        with self.execute_condition:
            try:
                self._take(goal)
            except Exception as error:  # noqa: BLE001 - of the program's callbacks
                rospy.logerr("SimpleActionServer.internal_goal_callback - exception %s", str(error))

    def _take(self, goal: ServerGoalHandle) -> None:
        rospy.logdebug("A new goal %s has been received by the single goal action server", goal.get_goal_id().id)
        stamp = goal.get_goal_id().stamp
        known = [each for each in (self.current_goal, self.next_goal) if each.get_goal() is not None]
        if any(stamp < each.get_goal_id().stamp for each in known):
            goal.set_canceled(None, REPLACED)  # a newer goal came first
            return
        if self.next_goal.get_goal() is not None and self.next_goal != self.current_goal:
            self.next_goal.set_canceled(None, REPLACED)
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

    def internal_preempt_callback(self, preempt: ServerGoalHandle) -> None:
        """Take a request to cancel a goal."""
        with self.lock:
            rospy.logdebug("A preempt has been received by the SimpleActionServer")
            if preempt == self.current_goal:
                rospy.logdebug("Setting preempt_request bit for the current goal to TRUE and invoking callback")
                self.preempt_request = True
                if self.preempt_callback:
                    self.preempt_callback()
            elif preempt == self.next_goal:
                rospy.logdebug("Setting preempt request bit for the next goal to TRUE")
                self.new_goal_preempt_request = True

    def executeLoop(self) -> None:
        """Work on goals until the node ends; the body of a thread."""
        while not rospy.is_shutdown() and not self.need_to_terminate:
            if self.is_active():
                rospy.logerr("Should never reach this code with an active goal")
                return
            if self.is_new_goal_available():
                self._execute(self.accept_new_goal())
            with self.execute_condition:
                if not self.new_goal:
                    self.execute_condition.wait(0.1)

    def _execute(self, goal: Any) -> None:
        try:
            self.execute_callback(goal)
            if self.is_active():
                rospy.logwarn(
                    "Your executeCallback did not set the goal to a terminal status.  This is a bug in your "
                    "ActionServer implementation. Fix your code!  For now, the ActionServer will set this goal to "
                    "aborted"
                )
                self.set_aborted(None, "No terminal state was set.")
        except Exception as error:  # noqa: BLE001 - of the program
            rospy.logerr("Exception in your execute callback: %s\n%s", str(error), traceback.format_exc())
            self.set_aborted(None, f"Exception in execute callback: {error!s}")
