"""A goal as its client sees it; stock has these classes in actionlib.action_client."""

from __future__ import annotations

import threading
from typing import Any

import rospy

from pyros1.actions.states import stages_after
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

NO_TRANSITION = -1
INVALID_TRANSITION = -2


def get_name_of_constant(C: Any, n: int) -> str:
    """Return the name that a class has for a number."""
    names = (name for name, value in vars(C).items() if isinstance(value, int) and value == n)
    return next(names, f"NO_SUCH_STATE_{n}")


class CommState:
    """Where a goal is, as its client knows."""

    WAITING_FOR_GOAL_ACK = 0
    PENDING = 1
    ACTIVE = 2
    WAITING_FOR_RESULT = 3
    WAITING_FOR_CANCEL_ACK = 4
    RECALLING = 5
    PREEMPTING = 6
    DONE = 7
    LOST = 8

    to_string = classmethod(get_name_of_constant)


class TerminalState:
    """How a goal ended."""

    RECALLED = GoalStatus.RECALLED
    REJECTED = GoalStatus.REJECTED
    PREEMPTED = GoalStatus.PREEMPTED
    ABORTED = GoalStatus.ABORTED
    SUCCEEDED = GoalStatus.SUCCEEDED
    LOST = GoalStatus.LOST

    to_string = classmethod(get_name_of_constant)


GoalStatus.to_string = classmethod(get_name_of_constant)  # type: ignore[attr-defined]
_ENDS = {value for name, value in vars(TerminalState).items() if isinstance(value, int)}


class CommStateMachine:
    """Follows one goal.

    Attributes:
        state: the CommState.
        latest_goal_status: the server's latest GoalStatus.
        latest_result: the message with the result; None until it comes.
    """

    def __init__(
        self, action_goal: Any, transition_cb: Any, feedback_cb: Any, send_goal_fn: Any, send_cancel_fn: Any
    ) -> None:
        self.action_goal = action_goal
        self.transition_cb = transition_cb
        self.feedback_cb = feedback_cb
        self.send_goal_fn = send_goal_fn
        self.send_cancel_fn = send_cancel_fn
        self.state = CommState.WAITING_FOR_GOAL_ACK
        self.mutex = threading.RLock()
        self.latest_goal_status: Any = GoalStatus(status=GoalStatus.PENDING)
        self.latest_result: Any = None

    def __eq__(self, o: Any) -> bool:
        return bool(self.action_goal.goal_id.id == o.action_goal.goal_id.id)

    def __hash__(self) -> int:
        return hash(self.action_goal.goal_id.id)

    def set_state(self, state: int) -> None:
        """Change the state, and call nobody."""
        rospy.logdebug(
            "Transitioning CommState from %s to %s", CommState.to_string(self.state), CommState.to_string(state)
        )
        self.state = state

    def transition_to(self, state: int) -> None:
        """Change the state, and call the program."""
        rospy.logdebug(
            "Transitioning to %s (from %s, goal: %s)",
            CommState.to_string(state),
            CommState.to_string(self.state),
            self.action_goal.goal_id.id,
        )
        self.state = state
        if self.transition_cb:
            self.transition_cb(ClientGoalHandle(self))

    def update_status(self, status_array: Any) -> None:
        """Take the server's list of all goals."""
        with self.mutex:
            if self.state == CommState.DONE:
                return
            name = self.action_goal.goal_id.id
            status = next((each for each in status_array.status_list if each.goal_id.id == name), None)
            if status is None:
                if self.state not in (CommState.WAITING_FOR_GOAL_ACK, CommState.WAITING_FOR_RESULT):
                    self._mark_as_lost()
                return
            self.latest_goal_status = status
            if not GoalStatus.PENDING <= status.status <= GoalStatus.RECALLED:
                rospy.logerr(f"Got an unknown status from the ActionServer: {status.status}")
                return
            stages = stages_after(self.state, status.status)
            if stages is None:
                names = CommState.to_string(self.state), GoalStatus.to_string(status.status)
                rospy.logerr("Invalid goal status transition from %s to %s", *names)
                return
            for stage in stages:
                self.transition_to(int(stage))

    def update_result(self, action_result: Any) -> None:
        """Take a result, if it is this goal's."""
        if self.action_goal.goal_id.id != action_result.status.goal_id.id:
            return
        with self.mutex:
            self.latest_goal_status = action_result.status
            self.latest_result = action_result
            if self.state == CommState.DONE:
                rospy.logerr("Got a result when we were already in the DONE state")
            elif CommState.WAITING_FOR_GOAL_ACK <= self.state < CommState.DONE:
                self.update_status(GoalStatusArray(status_list=[action_result.status]))
                self.transition_to(CommState.DONE)
            else:
                rospy.logerr(f"In a funny state: {self.state}")

    def update_feedback(self, action_feedback: Any) -> None:
        """Take feedback, if it is this goal's."""
        if self.action_goal.goal_id.id != action_feedback.status.goal_id.id:
            return
        if self.feedback_cb and self.state != CommState.DONE:
            self.feedback_cb(ClientGoalHandle(self), action_feedback.feedback)

    def _mark_as_lost(self) -> None:
        self.latest_goal_status.status = GoalStatus.LOST
        self.transition_to(CommState.DONE)


class ClientGoalHandle:
    """Handle of a goal that was sent; while one lives, its goal is followed."""

    def __init__(self, comm_state_machine: CommStateMachine) -> None:
        self.comm_state_machine = comm_state_machine

    def __eq__(self, o: Any) -> bool:
        return bool(o) and self.comm_state_machine == o.comm_state_machine

    def __ne__(self, o: Any) -> bool:
        return not self == o

    def __hash__(self) -> int:
        return hash(self.comm_state_machine)

    def cancel(self) -> None:
        """Ask the server to cancel the goal."""
        machine = self.comm_state_machine
        with machine.mutex:
            machine.send_cancel_fn(GoalID(stamp=rospy.Time(0), id=machine.action_goal.goal_id.id))
            machine.transition_to(CommState.WAITING_FOR_CANCEL_ACK)

    def get_comm_state(self) -> int:
        """Return the CommState."""
        if not self._is_active("get_comm_state"):
            return CommState.LOST
        return self.comm_state_machine.state

    def get_goal_status(self) -> int:
        """Return the server's latest status."""
        if not self._is_active("get_goal_status"):
            return int(GoalStatus.PENDING)
        return int(self.comm_state_machine.latest_goal_status.status)

    def get_goal_status_text(self) -> str:
        """Return what the server said with its latest status."""
        if not self._is_active("get_goal_status_text"):
            return "ERROR: Trying to get_goal_status_text on an inactive ClientGoalHandle."
        return str(self.comm_state_machine.latest_goal_status.text)

    def get_result(self) -> Any:
        """Return the result; None if none has come."""
        if not self._is_active("get_result"):
            return None
        latest = self.comm_state_machine.latest_result
        return latest.result if latest else None

    def get_terminal_state(self) -> int:
        """Return how the goal ended."""
        if not self._is_active("get_terminal_state"):
            return int(GoalStatus.LOST)
        with self.comm_state_machine.mutex:
            state = self.comm_state_machine.state
            if state != CommState.DONE:
                rospy.logwarn("Asking for the terminal state when we're in [%s]", CommState.to_string(state))
            status = int(self.comm_state_machine.latest_goal_status.status)
            if status in _ENDS:
                return status
            rospy.logerr("Asking for a terminal state, but the goal status is %d", status)
            return int(GoalStatus.LOST)

    def _is_active(self, asked: str) -> bool:
        if not self.comm_state_machine:
            rospy.logerr(f"Trying to {asked} on an inactive ClientGoalHandle.")
        return bool(self.comm_state_machine)
