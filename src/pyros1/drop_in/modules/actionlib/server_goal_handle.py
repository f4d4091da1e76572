"""A goal, as the program of its server holds it."""

from __future__ import annotations

from typing import Any

import rospy

from pyros1.actions.states import Move, status_after
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus


class ServerGoalHandle:
    """Handle of a goal, made by the ActionServer; one without arguments stands for no goal.

    A change that the goal's state does not allow is logged, and nothing else happens.
    """

    def __init__(self, status_tracker: Any = None, action_server: Any = None, handle_tracker: Any = None) -> None:
        self.status_tracker = status_tracker
        self.action_server = action_server
        self.handle_tracker = handle_tracker
        self.goal = status_tracker.goal if status_tracker else None

    def get_default_result(self) -> Any:
        """Return a result with default values."""
        return self.action_server.ActionResultType()

    def set_accepted(self, text: str = "") -> None:
        """Begin with the goal."""
        self._log("Accepting goal")
        if self._has_goal() and not self._move(Move.ACCEPT, text):
            self._refuse("an active", "pending or recalling")

    def set_canceled(self, result: Any = None, text: str = "") -> None:
        """End the goal: it was stopped, or never begun, because a client or a newer goal asked for that."""
        result = result or self.get_default_result()
        self._log("Setting status to canceled on goal")
        if self._has_goal() and not self._move(Move.CANCEL, text, result):
            self._refuse("a cancelled", "pending, recalling, active, or preempting")

    def set_rejected(self, result: Any = None, text: str = "") -> None:
        """End the goal: it is not wanted."""
        result = result or self.get_default_result()
        self._log("Setting status to rejected on goal")
        if self._has_goal() and not self._move(Move.REJECT, text, result):
            self._refuse("a rejected", "pending or recalling")

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """End the goal: it cannot be reached."""
        result = result or self.get_default_result()
        self._log("Setting status to aborted on goal")
        if self._has_goal() and not self._move(Move.ABORT, text, result):
            self._refuse("an aborted", "preempting or active")

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """End the goal: it was reached."""
        result = result or self.get_default_result()
        self._log("Setting status to succeeded on goal")
        if self._has_goal() and not self._move(Move.SUCCEED, text, result):
            self._refuse("a succeeded", "preempting or active")

    def set_cancel_requested(self) -> bool:
        """Note that the goal shall be cancelled; return whether that is news."""
        self._log("Transisitoning to a cancel requested state on goal")
        return self.goal is not None and self._move(Move.ASK_TO_CANCEL)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the clients."""
        self._log("Publishing feedback for goal")
        if self.goal is None:
            rospy.logerr("Attempt to publish feedback on an uninitialized ServerGoalHandle")
            return
        with self.action_server.lock:
            self.action_server.publish_feedback(self.status_tracker.status, feedback)

    def get_goal(self) -> Any:
        """Return the goal that the client has sent; None for no goal."""
        return self.goal.goal if self.goal is not None else None

    def get_goal_id(self) -> Any:
        """Return the GoalID."""
        if self.goal is None:
            rospy.logerr("Attempt to get a goal id on an uninitialized ServerGoalHandle")
            return GoalID()
        with self.action_server.lock:
            return self.status_tracker.status.goal_id

    def get_goal_status(self) -> Any:
        """Return the GoalStatus."""
        if self.goal is None:
            rospy.logerr("Attempt to get goal status on an uninitialized ServerGoalHandle")
            return GoalStatus()
        with self.action_server.lock:
            return self.status_tracker.status

    def __eq__(self, other: Any) -> bool:
        if not self.goal or not other.goal:
            return False
        return bool(self.get_goal_id().id == other.get_goal_id().id)

    def __ne__(self, other: Any) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash(self.get_goal_id().id)

    def _has_goal(self) -> bool:
        if self.goal is None:
            rospy.logerr("Attempt to set status on an uninitialized ServerGoalHandle")
        return self.goal is not None

    def _move(self, move: Move, text: str = "", result: Any = None) -> bool:
        """Change the status and tell the clients; return False if it is not possible."""
        server, tracker = self.action_server, self.status_tracker
        with server.lock:
            after = status_after(tracker.status.status, move)
            if after is None:
                return False
            tracker.status.status = int(after)
            if move is not Move.ASK_TO_CANCEL:
                tracker.status.text = text
            if after.ended:
                tracker.handle_destruction_time = rospy.Time.now()
                server.publish_result(tracker.status, result)
            else:
                server.publish_status()
        return True

    def _refuse(self, to: str, those: str) -> None:
        text = "To transition to %s state, the goal must be in a %s state, it is currently in state: %d"
        rospy.logerr(text, to, those, self.status_tracker.status.status)

    def _log(self, what: str) -> None:
        goal_id = self.get_goal_id()
        rospy.logdebug("%s, id: %s, stamp: %.2f", what, goal_id.id, goal_id.stamp.to_sec())
