"""A client's view of a goal, with stock's states; pyros1.actions.states defines the transitions."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rospy

from pyros1.actions.states import Stage, Status, stages_after
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

_REPORTABLE = frozenset(Status) - {Status.LOST}
"""The statuses that a server may report."""
_TERMINAL = frozenset(status for status in Status if status.ended)


def get_name_of_constant(C: Any, n: int) -> str:
    """Return the name of the integer constant that has the value ``n`` in a class; ``NO_SUCH_STATE_n`` if there is
    none.
    """
    for name, value in vars(C).items():
        if isinstance(value, int) and value == n and not name.startswith("_"):
            return name
    return f"NO_SUCH_STATE_{n}"


GoalStatus.to_string = classmethod(get_name_of_constant)  # type: ignore[attr-defined]  # as in stock ROS


class CommState:
    """The state of a goal as seen by its client (https://wiki.ros.org/actionlib/DetailedDescription)."""

    WAITING_FOR_GOAL_ACK = int(Stage.WAITING_FOR_GOAL_ACK)
    PENDING = int(Stage.PENDING)
    ACTIVE = int(Stage.ACTIVE)
    WAITING_FOR_RESULT = int(Stage.WAITING_FOR_RESULT)
    WAITING_FOR_CANCEL_ACK = int(Stage.WAITING_FOR_CANCEL_ACK)
    RECALLING = int(Stage.RECALLING)
    PREEMPTING = int(Stage.PREEMPTING)
    DONE = int(Stage.DONE)
    LOST = 8

    @classmethod
    def to_string(cls, n: int) -> str:
        """Return the name of a state."""
        return get_name_of_constant(cls, n)


class TerminalState:
    """The terminal states of a goal, with the values of actionlib_msgs/GoalStatus."""

    PREEMPTED = int(Status.PREEMPTED)
    SUCCEEDED = int(Status.SUCCEEDED)
    ABORTED = int(Status.ABORTED)
    REJECTED = int(Status.REJECTED)
    RECALLED = int(Status.RECALLED)
    LOST = int(Status.LOST)

    @classmethod
    def to_string(cls, n: int) -> str:
        """Return the name of a terminal state."""
        return get_name_of_constant(cls, n)


class CommStateMachine:
    """A goal, with its state, the latest status from the server, and the result.

    Goals with the same id are equal.

    Args:
        action_goal: the message of the action's goal topic, such as TestActionGoal.
        transition_cb: called with a `ClientGoalHandle` in each new state; None for no callback.
        feedback_cb: called with a `ClientGoalHandle` and each feedback message; None for no callback.
        send_goal_fn: the function that sends the goal; it is only stored.
        send_cancel_fn: called with the GoalID to cancel the goal.
    """

    def __init__(
        self,
        action_goal: Any,
        transition_cb: Callable[[Any], object] | None,
        feedback_cb: Callable[[Any, Any], object] | None,
        send_goal_fn: Any,
        send_cancel_fn: Any,
    ) -> None:
        self.action_goal = action_goal
        self.transition_cb = transition_cb
        self.feedback_cb = feedback_cb
        self.send_goal_fn = send_goal_fn
        self.send_cancel_fn = send_cancel_fn
        self.state = CommState.WAITING_FOR_GOAL_ACK
        self.mutex = threading.RLock()
        self.latest_goal_status = GoalStatus(status=GoalStatus.PENDING)
        self.latest_result: Any = None

    def __eq__(self, o: object) -> bool:
        return self.action_goal.goal_id.id == o.action_goal.goal_id.id  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash(self.action_goal.goal_id.id)

    def set_state(self, state: int) -> None:
        """Set the state, without a callback."""
        rospy.logdebug("Transitioning CommState from %s to %s", *map(CommState.to_string, (self.state, state)))
        self.state = state

    def transition_to(self, state: int) -> None:
        """Set the state, and call ``transition_cb``."""
        names = map(CommState.to_string, (state, self.state))
        rospy.logdebug("Transitioning to %s (from %s, goal: %s)", *names, self.action_goal.goal_id.id)
        self.state = state
        if self.transition_cb:
            self.transition_cb(ClientGoalHandle(self))

    def update_status(self, status_array: Any) -> None:
        """Process the server's GoalStatusArray; a goal that has vanished from that array is lost."""
        with self.mutex:
            if self.state == CommState.DONE:
                return
            goal_id = self.action_goal.goal_id.id
            status = next(
                (goal_status for goal_status in status_array.status_list if goal_status.goal_id.id == goal_id), None
            )
            if status is None:
                if self.state not in (CommState.WAITING_FOR_GOAL_ACK, CommState.WAITING_FOR_RESULT):
                    self._mark_as_lost()
                return
            self.latest_goal_status = status
            self._apply_status(status.status)

    def update_result(self, action_result: Any) -> None:
        """Handle a message on the action's result topic; if the result is for this goal, finish the goal."""
        status = action_result.status
        if status.goal_id.id != self.action_goal.goal_id.id:
            return
        with self.mutex:
            self.latest_goal_status = status
            self.latest_result = action_result
            if self.state == CommState.DONE:
                rospy.logerr("Got a result when we were already in the DONE state")
            elif self.state == CommState.LOST:
                rospy.logerr("In a funny state: %i", self.state)
            else:
                self.update_status(GoalStatusArray(status_list=[status]))
                self.transition_to(CommState.DONE)

    def update_feedback(self, action_feedback: Any) -> None:
        """Handle a message on the action's feedback topic."""
        if action_feedback.status.goal_id.id != self.action_goal.goal_id.id:
            return
        with self.mutex:
            must_call = self.feedback_cb and self.state != CommState.DONE
        if must_call and self.feedback_cb:
            self.feedback_cb(ClientGoalHandle(self), action_feedback.feedback)

    def _apply_status(self, status: int) -> None:
        if self.state == CommState.LOST:
            rospy.logerr("CommStateMachine is in a funny state: %i", self.state)
        elif status not in _REPORTABLE:
            rospy.logerr("Got an unknown status from the ActionServer: %i", status)
        else:
            stages = stages_after(self.state, status)
            if stages is None:
                names = CommState.to_string(self.state), get_name_of_constant(GoalStatus, status)
                rospy.logerr("Invalid goal status transition from %s to %s", *names)
            for stage in stages or ():
                self.transition_to(int(stage))

    def _mark_as_lost(self) -> None:
        self.latest_goal_status.status = GoalStatus.LOST
        self.transition_to(CommState.DONE)


class ClientGoalHandle:
    """A handle of a goal that was sent. Handles of the same goal are equal.

    Args:
        comm_state_machine: the goal; None for a handle without a goal, whose methods log errors.
    """

    def __init__(self, comm_state_machine: CommStateMachine | None) -> None:
        self.comm_state_machine: Any = comm_state_machine

    def __eq__(self, o: object) -> bool:
        if o is None:
            return False
        return self.comm_state_machine == o.comm_state_machine  # type: ignore[attr-defined]

    def __ne__(self, o: object) -> bool:
        return not self == o

    def __hash__(self) -> int:
        return hash(self.comm_state_machine)

    def cancel(self) -> None:
        """Ask the server to cancel the goal, whatever its state. A handle without a goal raises AttributeError."""
        machine = self.comm_state_machine
        with machine.mutex:
            machine.send_cancel_fn(GoalID(stamp=rospy.Time(), id=machine.action_goal.goal_id.id))
            machine.transition_to(CommState.WAITING_FOR_CANCEL_ACK)

    def get_comm_state(self) -> int:
        """Return the goal's CommState."""
        return int(self.comm_state_machine.state) if self._has_goal("get_comm_state") else CommState.LOST

    def get_goal_status(self) -> int:
        """Return the server's latest status of the goal, a constant of GoalStatus."""
        if not self._has_goal("get_goal_status"):
            return int(GoalStatus.PENDING)
        return int(self.comm_state_machine.latest_goal_status.status)

    def get_goal_status_text(self) -> str:
        """Return the text of the server's latest status."""
        if not self._has_goal("get_goal_status_text"):
            return "ERROR: Trying to get_goal_status_text on an inactive ClientGoalHandle."
        return str(self.comm_state_machine.latest_goal_status.text)

    def get_result(self) -> Any:
        """Return the action's result message; None if there is none yet."""
        if not self._has_goal("get_result"):
            return None
        message = self.comm_state_machine.latest_result
        return message and message.result

    def get_terminal_state(self) -> int:
        """Return the goal's TerminalState; LOST if the server's status is not a terminal one."""
        if not self._has_goal("get_terminal_state"):
            return int(GoalStatus.LOST)
        machine = self.comm_state_machine
        with machine.mutex:
            if machine.state != CommState.DONE:
                state = CommState.to_string(machine.state)
                rospy.logwarn("Asking for the terminal state when we're in [%s]", state)
            status = int(machine.latest_goal_status.status)
            if status in _TERMINAL:
                return status
            rospy.logerr("Asking for a terminal state, but the goal status is %d", status)
            return int(GoalStatus.LOST)

    def _has_goal(self, method: str) -> bool:
        if self.comm_state_machine is None:
            rospy.logerr("Trying to %s on an inactive ClientGoalHandle.", method)
            return False
        return True
