"""Client of an action, for one goal at a time."""

from __future__ import annotations

import threading
from typing import Any

import rospy

from actionlib.action_client import ActionClient, ClientGoalHandle, CommState, get_name_of_constant
from pyros1.msgs.actionlib_msgs.msg import GoalStatus

__all__ = [
    "ActionClient",
    "CommState",
    "GoalStatus",
    "SimpleActionClient",
    "SimpleGoalState",
    "get_name_of_constant",
    "rospy",
]


class SimpleGoalState:
    """Where the goal is."""

    PENDING = 0
    ACTIVE = 1
    DONE = 2

    to_string = classmethod(get_name_of_constant)


class SimpleActionClient:
    """Sends a goal, and follows it until the next one.

    Args:
        ns: name of the action.
        ActionSpec: class of the action, as TestAction.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        self.action_client = ActionClient(ns, ActionSpec)
        self.simple_state = SimpleGoalState.DONE
        self.gh: ClientGoalHandle | None = None
        self.done_condition = threading.Condition()
        self._sending = threading.RLock()
        self.done_cb: Any = None
        self.active_cb: Any = None
        self.feedback_cb: Any = None

    def wait_for_server(self, timeout: Any = rospy.Duration()) -> bool:  # noqa: B008
        """Wait until the server is connected; a timeout of 0 is no limit. Return whether it is."""
        return self.action_client.wait_for_server(timeout)

    def send_goal(self, goal: Any, done_cb: Any = None, active_cb: Any = None, feedback_cb: Any = None) -> None:
        """Send a goal; an earlier one is followed no more, but not cancelled.

        Args:
            goal: the action's goal message, as TestGoal.
            done_cb: called with status and result at the end.
            active_cb: called when the server begins.
            feedback_cb: called with each feedback message.
        """
        self.stop_tracking_goal()
        self.done_cb = done_cb
        self.active_cb = active_cb
        self.feedback_cb = feedback_cb
        self.simple_state = SimpleGoalState.PENDING
        with self._sending:  # an answer that comes at once waits for the handle
            self.gh = self.action_client.send_goal(goal, self._handle_transition, self._handle_feedback)

    def send_goal_and_wait(
        self,
        goal: Any,
        execute_timeout: Any = rospy.Duration(),  # noqa: B008
        preempt_timeout: Any = rospy.Duration(),  # noqa: B008
    ) -> int:
        """Send a goal and wait for its end.

        Args:
            goal: the action's goal message.
            execute_timeout: after this the goal is cancelled; 0 for no limit.
            preempt_timeout: how long to wait after that; 0 for no limit.

        Returns:
            The goal's state, as `get_state`.
        """
        self.send_goal(goal)
        if not self.wait_for_result(execute_timeout):
            rospy.logdebug("Canceling goal")
            self.cancel_goal()
            if self.wait_for_result(preempt_timeout):
                text = "Preempt finished within specified preempt_timeout [%.2f]"
            else:
                text = "Preempt didn't finish specified preempt_timeout [%.2f]"
            rospy.logdebug(text, preempt_timeout.to_sec())
        return self.get_state()

    def wait_for_result(self, timeout: Any = rospy.Duration()) -> bool:  # noqa: B008
        """Wait for the goal's end; a timeout of 0 is no limit. Return whether it has ended."""
        if not self.gh:
            rospy.logerr("Called wait_for_result when no goal exists")
            return False
        limited = timeout > rospy.Duration()
        ends = rospy.get_rostime() + timeout
        with self.done_condition:
            while not rospy.is_shutdown() and self.simple_state != SimpleGoalState.DONE:
                left = (ends - rospy.get_rostime()).to_sec() if limited else 0.1
                if left <= 0:
                    break
                self.done_condition.wait(min(left, 0.1))
        return self.simple_state == SimpleGoalState.DONE

    def get_result(self) -> Any:
        """Return the goal's result; None without one."""
        if not self.gh:
            rospy.logerr("Called get_result when no goal is running")
            return None
        return self.gh.get_result()

    def get_state(self) -> int:
        """Return a number of GoalStatus; PENDING or ACTIVE until the end, LOST without a goal."""
        if not self.gh:
            return int(GoalStatus.LOST)
        status = self.gh.get_goal_status()
        going_on = {GoalStatus.RECALLING: GoalStatus.PENDING, GoalStatus.PREEMPTING: GoalStatus.ACTIVE}
        return int(going_on.get(status, status))

    def get_goal_status_text(self) -> str:
        """Return what the server said with its latest status."""
        if not self.gh:
            rospy.logerr("Called get_goal_status_text when no goal is running")
            return "ERROR: Called get_goal_status_text when no goal is running"
        return self.gh.get_goal_status_text()

    def cancel_all_goals(self) -> None:
        """Ask the server to cancel all its goals."""
        self.action_client.cancel_all_goals()

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to cancel all goals that were sent until a time."""
        self.action_client.cancel_goals_at_and_before_time(time)

    def cancel_goal(self) -> None:
        """Ask the server to cancel the goal."""
        if self.gh:
            self.gh.cancel()

    def stop_tracking_goal(self) -> None:
        """Follow the goal no more."""
        self.gh = None

    def _handle_transition(self, gh: ClientGoalHandle) -> None:
        with self._sending:
            ours = gh == self.gh
        if not ours:
            rospy.logerr("Got a transition callback on a goal handle that we're not tracking")
            return
        state, simple = gh.get_comm_state(), self.simple_state
        done = simple == SimpleGoalState.DONE
        if state in (CommState.ACTIVE, CommState.PREEMPTING) and simple == SimpleGoalState.PENDING:
            self._set_simple_state(SimpleGoalState.ACTIVE)
            if self.active_cb:
                self.active_cb()
        elif state == CommState.DONE and done:
            rospy.logerr("SimpleActionClient received DONE twice")
        elif state == CommState.DONE:
            if self.done_cb:
                self.done_cb(gh.get_goal_status(), gh.get_result())
            with self.done_condition:
                self._set_simple_state(SimpleGoalState.DONE)
                self.done_condition.notify_all()
        elif (state in (CommState.ACTIVE, CommState.PREEMPTING) and done) or (
            state == CommState.RECALLING and simple != SimpleGoalState.PENDING
        ):
            rospy.logerr(
                f"Received comm state {CommState.to_string(state)} when in simple state "
                f"{SimpleGoalState.to_string(simple)} with SimpleActionClient in NS "
                f"{rospy.resolve_name(self.action_client.ns)}"
            )

    def _handle_feedback(self, gh: ClientGoalHandle, feedback: Any) -> None:
        tracked = self.gh
        if not tracked:
            return  # feedback of an earlier goal
        if gh != tracked:
            names = [each.comm_state_machine.action_goal.goal_id.id for each in (tracked, gh)]
            rospy.logerr("Got a feedback callback on a goal handle that we're not tracking. %s vs %s", *names)
            return
        if self.feedback_cb:
            self.feedback_cb(feedback)

    def _set_simple_state(self, state: int) -> None:
        self.simple_state = state
