"""The goals of a server (pure): requests from clients, and the status of each goal."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

from pyros1.actions.goal_id import matches
from pyros1.actions.states import Move, Status, status_after
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import load_message


class Tracked:
    """One goal.

    Attributes:
        status: its actionlib_msgs/GoalStatus, as published; ``status.goal_id`` names it.
        goal: the message of the action's goal topic; None if only a cancel request for it has come.
        ended: time from which its status is kept only for a while; None while the goal is active.
    """

    def __init__(self, goal_id: Any, status: int = Status.PENDING, goal: Any = None) -> None:
        self.status: Any = load_message("actionlib_msgs/GoalStatus")(goal_id=goal_id, status=int(status))
        self.goal = goal
        self.ended: Time | None = None

    def move(self, move: Move, text: str = "") -> bool:
        """Change the status and its text; return False, and change nothing, if the move is not possible now."""
        status = status_after(self.status.status, move)
        if status is None:
            return False
        self.status.status = int(status)
        if move is not Move.ASK_TO_CANCEL:
            self.status.text = text
        return True


_T = TypeVar("_T", bound=Tracked)

TOO_OLD = (
    "This goal handle was canceled by the action server because its timestamp is before the timestamp of the last "
    "cancel request"
)
"""Stock's text for a goal that is older than a request to cancel all goals up to some time."""


class GoalTable(Generic[_T]):
    """All goals whose status a server publishes. The caller holds the locks.

    Attributes:
        goals: in the order of arrival.
        kept: how long a goal's status is published after its end.
        last_cancel: the latest time up to which goals were cancelled.
    """

    def __init__(self, kept: Duration) -> None:
        self.goals: list[_T] = []
        self.kept = kept
        self.last_cancel = Time()
        self._seen = Time()  # the latest time passed to `forget`

    def find(self, name: str) -> _T | None:
        """Return the goal with a name; None if it is not known."""
        return next((each for each in self.goals if each.status.goal_id.id == name), None)

    def repeat(self, name: str, now: Time) -> tuple[_T | None, bool]:
        """Check whether an arriving goal is already known.

        Returns:
            The known goal, or None; and whether it was cancelled before it arrived, so that the client now needs a
            result.
        """
        known = self.find(name) if name else None
        if known is None:
            return None, False
        recalled = known.status.status == Status.RECALLING and known.goal is None
        if recalled:
            known.status.status = int(Status.RECALLED)
            known.ended = now
        return known, recalled

    def is_too_old(self, goal_id: Any) -> bool:
        """Return whether a new goal was already cancelled by its time."""
        return bool(goal_id.stamp) and bool(goal_id.stamp <= self.last_cancel)

    def matching(self, request: Any) -> list[_T]:
        """Return the goals that a cancel request matches, and remember its time."""
        self.last_cancel = max(self.last_cancel, request.stamp)
        return [each for each in self.goals if matches(request, each.status.goal_id)]

    def forget(self, now: Time) -> list[_T]:
        """Remove and return the goals that ended long enough ago.

        Called at each change and regularly. When simulated time has jumped back, as when a bag is played again, the
        ended goals' time is counted from then on, and earlier cancel requests no longer apply.
        """
        if now < self._seen:
            self.last_cancel = min(self.last_cancel, now)
            for each in self.goals:
                each.ended = each.ended and min(each.ended, now)
        self._seen = now
        expired = [each for each in self.goals if each.ended is not None and each.ended + self.kept < now]
        if expired:
            self.goals = [each for each in self.goals if each not in expired]
        return expired
