"""The handle through which a server's program controls a goal."""

from __future__ import annotations

from typing import Any

import rospy

from pyros1.actions.states import Transition
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus

__all__ = [
    "ServerGoalHandle",
    "rospy",
]

__getattr__ = module_getattr("actionlib.server_goal_handle")

_INVALID_TRANSITION = "To transition to %s state, the goal must be in a %s state, it is currently in state: %d"
_TERMINAL_TEXTS = {
    Transition.CANCEL: ("canceled", "a cancelled", "pending, recalling, active, or preempting"),
    Transition.REJECT: ("rejected", "a rejected", "pending or recalling"),
    Transition.ABORT: ("aborted", "an aborted", "preempting or active"),
    Transition.SUCCEED: ("succeeded", "a succeeded", "preempting or active"),
}


class ServerGoalHandle:
    """A handle of a goal that was received. Handles of the same goal are equal.

    A handle without a goal is not equal to any other handle, and its methods log errors.

    Args:
        status_tracker: the goal's `StatusTracker`.
        action_server: the `ActionServer` that received the goal.
        handle_tracker: the `HandleTrackerDeleter` of the goal's handles.
    """

    def __init__(self, status_tracker: Any = None, action_server: Any = None, handle_tracker: Any = None) -> None:
        self.status_tracker = status_tracker
        self.action_server = action_server
        self.handle_tracker = handle_tracker
        self.goal = status_tracker.goal if status_tracker else None

    def __eq__(self, other: object) -> bool:
        if not self.goal or not other.goal:  # type: ignore[attr-defined]
            return False
        return self.get_goal_id().id == other.get_goal_id().id  # type: ignore[attr-defined]

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash(self.get_goal_id().id)

    def get_default_result(self) -> Any:
        """Return a result message of the action, with default values."""
        return self.action_server.ActionResultType()

    def get_goal(self) -> Any:
        """Return the action's goal message, such as TestGoal; None if the handle has no goal."""
        return self.goal.goal if self.goal else None

    def get_goal_id(self) -> Any:
        """Return the goal's GoalID."""
        if not self.goal:
            rospy.logerr("Attempt to get a goal id on an uninitialized ServerGoalHandle")
            return GoalID()
        with self.action_server.lock:
            return self.status_tracker.status.goal_id

    def get_goal_status(self) -> Any:
        """Return the goal's GoalStatus."""
        if not self.goal:
            rospy.logerr("Attempt to get goal status on an uninitialized ServerGoalHandle")
            return GoalStatus()
        with self.action_server.lock:
            return self.status_tracker.status

    def publish_feedback(self, feedback: Any) -> None:
        """Send the action's feedback message, such as TestFeedback."""
        self._log("Publishing feedback for goal, id: %s, stamp: %.2f")
        if not self.goal:
            rospy.logerr("Attempt to publish feedback on an uninitialized ServerGoalHandle")
            return
        with self.action_server.lock:
            self.action_server.publish_feedback(self.status_tracker.status, feedback)

    def set_accepted(self, text: str = "") -> None:
        """Accept the goal. Like the other ``set_`` methods, only log an error if the goal's state does not allow it."""
        self._log("Accepting goal, id: %s, stamp: %.2f")
        if self._transition(Transition.ACCEPT, text, "an active", "pending or recalling"):
            with self.action_server.lock:
                self.action_server.publish_status()

    def set_canceled(self, result: Any = None, text: str = "") -> None:
        """Finish the goal as canceled.

        Args:
            result: the action's result message, such as TestResult; None for one with default values.
            text: a human-readable text.
        """
        self._finish(Transition.CANCEL, result, text)

    def set_rejected(self, result: Any = None, text: str = "") -> None:
        """Reject the goal, before `set_accepted`."""
        self._finish(Transition.REJECT, result, text)

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """Finish the goal as aborted."""
        self._finish(Transition.ABORT, result, text)

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """Finish the goal as succeeded."""
        self._finish(Transition.SUCCEED, result, text)

    def set_cancel_requested(self) -> bool:
        """Record a client's request to cancel the goal; return whether the goal can still be canceled."""
        self._log("Transisitoning to a cancel requested state on goal id: %s, stamp: %.2f")
        if not self.goal:
            return False
        with self.action_server.lock:
            if not self.status_tracker.apply(Transition.ASK_TO_CANCEL):
                return False
            self.action_server.publish_status()
            return True

    def _log(self, text: str) -> None:
        rospy.logdebug(text, self.get_goal_id().id, self.get_goal_id().stamp.to_sec())

    def _transition(self, transition: Transition, text: str, state_name: str, allowed_states: str) -> bool:
        if not self.goal:
            rospy.logerr("Attempt to set status on an uninitialized ServerGoalHandle")
            return False
        with self.action_server.lock:
            if self.status_tracker.apply(transition, text):
                return True
            rospy.logerr(_INVALID_TRANSITION, state_name, allowed_states, self.status_tracker.status.status)
            return False

    def _finish(self, transition: Transition, result: Any, text: str) -> None:
        verb, state_name, allowed_states = _TERMINAL_TEXTS[transition]
        result = result or self.get_default_result()
        self._log(f"Setting status to {verb} on goal, id: %s, stamp: %.2f")
        if self._transition(transition, text, state_name, allowed_states):
            with self.action_server.lock:
                self.status_tracker.handle_destruction_time = rospy.Time.now()
                self.action_server.publish_result(self.status_tracker.status, result)
