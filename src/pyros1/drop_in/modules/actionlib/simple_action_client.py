"""Client of an action with one goal at a time (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rospy

from actionlib.action_client import ActionClient, CommState, Countdown, get_name_of_constant
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.actionlib_msgs.msg import GoalStatus

__all__ = [
    "ActionClient",
    "CommState",
    "GoalStatus",
    "SimpleActionClient",
    "SimpleGoalState",
    "get_name_of_constant",
    "rospy",
    "threading",
]

__getattr__ = module_getattr("actionlib.simple_action_client")

_POLL_INTERVAL = 0.1
"""Maximum number of seconds between checks of the time, which may be simulated, and whether the node has shut down."""
_SIMPLE_STATUSES = {GoalStatus.RECALLING: GoalStatus.PENDING, GoalStatus.PREEMPTING: GoalStatus.ACTIVE}


class SimpleGoalState:
    """The state of the goal of a `SimpleActionClient`."""

    PENDING = 0
    ACTIVE = 1
    DONE = 2

    @classmethod
    def to_string(cls, n: int) -> str:
        """Return the name of a state."""
        return get_name_of_constant(cls, n)


_ALLOWED_SIMPLE_STATES = {
    CommState.RECALLING: {SimpleGoalState.PENDING},
    CommState.ACTIVE: {SimpleGoalState.PENDING, SimpleGoalState.ACTIVE},
    CommState.PREEMPTING: {SimpleGoalState.PENDING, SimpleGoalState.ACTIVE},
}
"""CommState -> simple states from which a goal may enter it; the CommStates not listed may be entered from any."""


class SimpleActionClient:
    """Sends one goal at a time to an action's server; a new goal replaces the previous one.

    Args:
        ns: name of the action.
        ActionSpec: class of the action, such as TestAction.

    Raises:
        ActionException: ``ActionSpec`` is not an action.
    """

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        self.gh: Any = None
        self._ended_goal: Any = None  # handle of the goal that ended last
        self.simple_state = SimpleGoalState.DONE
        self.done_condition = threading.Condition()
        self._send_lock = threading.RLock()  # callbacks wait until send_goal has set `gh`
        self.action_client = ActionClient(ns, ActionSpec)

    def wait_for_server(self, timeout: Any = rospy.Duration()) -> bool:  # noqa: B008  stock's signature
        """Wait until the server is connected; see `ActionClient.wait_for_server`."""
        return self.action_client.wait_for_server(timeout)

    def send_goal(
        self,
        goal: Any,
        done_cb: Callable[[int, Any], object] | None = None,
        active_cb: Callable[[], object] | None = None,
        feedback_cb: Callable[[Any], object] | None = None,
    ) -> None:
        """Send a goal. The previous one is no longer tracked, but not cancelled.

        Args:
            goal: the action's goal message, such as TestGoal.
            done_cb: called with a constant of GoalStatus and the result message when the goal has finished.
            active_cb: called when the server has started to execute the goal.
            feedback_cb: called with each feedback message.
        """
        self.stop_tracking_goal()
        with self._send_lock:
            self.done_cb, self.active_cb, self.feedback_cb = done_cb, active_cb, feedback_cb
            self.simple_state = SimpleGoalState.PENDING
            self.gh = self.action_client.send_goal(goal, self._handle_transition, self._handle_feedback)

    def send_goal_and_wait(
        self,
        goal: Any,
        execute_timeout: Any = rospy.Duration(),  # noqa: B008
        preempt_timeout: Any = rospy.Duration(),  # noqa: B008
    ) -> int:
        """Send a goal, and wait until it has finished; cancel it if that takes too long.

        Args:
            goal: the action's goal message.
            execute_timeout: maximum rospy.Duration of the goal; zero for no limit.
            preempt_timeout: maximum rospy.Duration for cancelling it; zero for no limit.

        Returns:
            The goal's state, see `get_state`.
        """
        self.send_goal(goal)
        if not self.wait_for_result(execute_timeout):
            rospy.logdebug("Canceling goal")
            self.cancel_goal()
            outcome = "finished within" if self.wait_for_result(preempt_timeout) else "didn't finish"
            rospy.logdebug("Preempt %s specified preempt_timeout [%.2f]", outcome, preempt_timeout.to_sec())
        return self.get_state()

    def wait_for_result(self, timeout: Any = rospy.Duration()) -> bool:  # noqa: B008
        """Wait until the goal has finished.

        Args:
            timeout: rospy.Duration; zero for no limit.

        Returns:
            Whether it has finished; False if there is no goal, or if the node shuts down before that.
        """
        if not self.gh:
            rospy.logerr("Called wait_for_result when no goal exists")
            return False
        goal = self.gh  # done_cb may send another goal and change `gh`
        countdown = Countdown(timeout)
        with self.done_condition:
            while not self._is_done(goal) and not rospy.is_shutdown():
                seconds_left = countdown.seconds_left()
                if seconds_left <= 0:
                    break
                self.done_condition.wait(min(seconds_left, _POLL_INTERVAL))
            return self._is_done(goal)

    def _is_done(self, goal: Any) -> bool:
        return self.simple_state == SimpleGoalState.DONE or goal == self._ended_goal

    def get_result(self) -> Any:
        """Return the goal's result message; None if there is none yet."""
        if not self.gh:
            rospy.logerr("Called get_result when no goal is running")
            return None
        return self.gh.get_result()

    def get_state(self) -> int:
        """Return the goal's status, a value of GoalStatus; PENDING for RECALLING, ACTIVE for PREEMPTING, and LOST if
        there is no goal.
        """
        if not self.gh:
            return int(GoalStatus.LOST)
        status = self.gh.get_goal_status()
        return int(_SIMPLE_STATUSES.get(status, status))

    def get_goal_status_text(self) -> str:
        """Return the text of the server's latest status of the goal."""
        if not self.gh:
            rospy.logerr("Called get_goal_status_text when no goal is running")
            return "ERROR: Called get_goal_status_text when no goal is running"
        return str(self.gh.get_goal_status_text())

    def cancel_all_goals(self) -> None:
        """Ask the server to cancel all goals, including those of other clients."""
        self.action_client.cancel_all_goals()

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to cancel all goals sent at or before a rospy.Time, including those of other clients."""
        self.action_client.cancel_goals_at_and_before_time(time)

    def cancel_goal(self) -> None:
        """Ask the server to cancel the goal."""
        if self.gh:
            self.gh.cancel()

    def stop_tracking_goal(self) -> None:
        """Stop tracking the goal, without cancelling it."""
        self.gh = None

    def _handle_transition(self, gh: Any) -> None:
        with self._send_lock:
            if gh != self.gh:
                rospy.logerr("Got a transition callback on a goal handle that we're not tracking")
                return
        state = gh.get_comm_state()
        if self.simple_state not in _ALLOWED_SIMPLE_STATES.get(state, {self.simple_state}):
            names = CommState.to_string(state), SimpleGoalState.to_string(self.simple_state)
            text = "Received comm state %s when in simple state %s with SimpleActionClient in NS %s"
            rospy.logerr(text, *names, rospy.resolve_name(self.action_client.ns))
        elif state in (CommState.ACTIVE, CommState.PREEMPTING):
            if self.simple_state == SimpleGoalState.PENDING:
                self._set_simple_state(SimpleGoalState.ACTIVE)
                if self.active_cb:
                    self.active_cb()
        elif state == CommState.DONE:
            self._finish(gh)

    def _finish(self, gh: Any) -> None:
        if self.simple_state == SimpleGoalState.DONE:
            rospy.logerr("SimpleActionClient received DONE twice")
            return
        if self.done_cb:
            self.done_cb(gh.get_goal_status(), gh.get_result())
        with self.done_condition:
            self._ended_goal = gh
            if gh == self.gh:  # otherwise done_cb has sent another goal
                self._set_simple_state(SimpleGoalState.DONE)
            self.done_condition.notify_all()

    def _handle_feedback(self, gh: Any, feedback: Any) -> None:
        with self._send_lock:
            current = self.gh
            if not current:
                return
            if gh != current:
                text = "Got a feedback callback on a goal handle that we're not tracking. %s vs %s"
                rospy.logerr(text, _goal_id(current), _goal_id(gh))
                return
        if self.feedback_cb:
            self.feedback_cb(feedback)

    def _set_simple_state(self, state: int) -> None:
        self.simple_state = state


def _goal_id(gh: Any) -> str:
    return str(gh.comm_state_machine.action_goal.goal_id.id)
