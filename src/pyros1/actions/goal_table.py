"""The goals of a server, without communication: requests from clients, and the status of each goal."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

from pyros1.actions.goal_id import cancel_request_matches
from pyros1.actions.states import Status, Transition, status_after
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import load_message


class Tracked:
    """A goal and its status.

    Attributes:
        status: the goal's actionlib_msgs/GoalStatus, as published; ``status.goal_id`` contains the goal's name.
        goal: the message of the action's goal topic; None if only a cancel request for it was received.
        ended_at: the time when the goal ended; its status is kept for a while after that. None while the goal is
            active.
    """

    def __init__(self, goal_id: Any, status: int = Status.PENDING, goal: Any = None) -> None:
        self.status: Any = load_message("actionlib_msgs/GoalStatus")(goal_id=goal_id, status=int(status))
        self.goal = goal
        self.ended_at: Time | None = None

    def apply(self, transition: Transition, text: str = "") -> bool:
        """Change the status and its text; if the transition is not possible now, change nothing and return False."""
        status = status_after(self.status.status, transition)
        if status is None:
            return False
        self.status.status = int(status)
        if transition is not Transition.ASK_TO_CANCEL:
            self.status.text = text
        return True


_T = TypeVar("_T", bound=Tracked)

TOO_OLD_TEXT = (
    "This goal handle was canceled by the action server because its timestamp is before the timestamp of the last "
    "cancel request"
)
"""Stock's text for a goal that is older than a request to cancel all goals up to some time."""


class GoalTable(Generic[_T]):
    """All goals whose status a server publishes. Not thread-safe: the caller must hold a lock.

    Attributes:
        goals: the goals in order of arrival.
        keep_duration: how long a goal's status is published after the goal has ended.
        last_cancel: the latest time up to which goals were cancelled.
    """

    def __init__(self, keep_duration: Duration) -> None:
        self.goals: list[_T] = []
        self.keep_duration = keep_duration
        self.last_cancel = Time()
        self._last_time = Time()  # the time last passed to `forget`

    def find(self, name: str) -> _T | None:
        """Return the goal with the given name; None if there is no such goal."""
        return next((goal for goal in self.goals if goal.status.goal_id.id == name), None)

    def find_arrived(self, name: str, now: Time) -> tuple[_T | None, bool]:
        """Find the known goal with the name of an arriving goal; mark it as recalled if it was cancelled in advance.

        Returns:
            The known goal, or None; and whether it was marked as recalled, in which case the client needs a result now.
        """
        known_goal = self.find(name) if name else None
        if known_goal is None:
            return None, False
        is_recalled = known_goal.status.status == Status.RECALLING and known_goal.goal is None
        if is_recalled:
            known_goal.status.status = int(Status.RECALLED)
            known_goal.ended_at = now
        return known_goal, is_recalled

    def is_too_old(self, goal_id: Any) -> bool:
        """Return whether a new goal is covered by an earlier request to cancel all goals up to some time."""
        return bool(goal_id.stamp) and bool(goal_id.stamp <= self.last_cancel)

    def match_cancel(self, request: Any) -> list[_T]:
        """Return the goals that a cancel request matches, and remember the request's time."""
        self.last_cancel = max(self.last_cancel, request.stamp)
        return [goal for goal in self.goals if cancel_request_matches(request, goal.status.goal_id)]

    def forget(self, now: Time) -> list[_T]:
        """Remove and return the goals that ended more than ``keep_duration`` ago.

        Must be called at each change, and at regular intervals. If simulated time has jumped back, as when a bag is
        replayed, ends of goals and a `last_cancel` that are in the future are set to now.
        """
        if now < self._last_time:
            self.last_cancel = min(self.last_cancel, now)
            for goal in self.goals:
                goal.ended_at = goal.ended_at and min(goal.ended_at, now)
        self._last_time = now
        expired = [
            goal for goal in self.goals if goal.ended_at is not None and goal.ended_at + self.keep_duration < now
        ]
        if expired:
            self.goals = [goal for goal in self.goals if goal not in expired]
        return expired
