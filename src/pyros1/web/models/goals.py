"""Keeps track of an action server's goals, as reported on its topics (no I/O)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

MAX_GOALS = 50
"""Maximum number of goals kept; the oldest are dropped."""
_ACTIVE_STATUSES = frozenset({0, 1, 6, 7})
"""Statuses of goals that are not finished."""
LOST = 9
"""Status of a goal that its server no longer knows."""
_MAX_MISSED = 2
"""If this many consecutive status lists lack a known goal, the server is assumed to have restarted."""


@dataclass
class Goal:
    """The state of a goal, as far as its server has reported it.

    Attributes:
        id: the goal's id.
        stamp: when the goal was sent, in seconds.
        status: one of the numbers defined in actionlib_msgs/GoalStatus, or `LOST`.
        text: the server's message about the status.
        feedback, result: the contents of the latest message of each kind; None if there was none.
        num_feedbacks: number of feedback messages received.
        num_missed: number of status lists since the last one that contained the goal; None if no status list has
            contained the goal yet.
    """

    id: str
    stamp: float = 0.0
    status: int = 0
    text: str = ""
    feedback: Any = None
    num_feedbacks: int = 0
    result: Any = None
    num_missed: int | None = None


class Goals:
    """The goals reported by the messages on an action's topics."""

    def __init__(self) -> None:
        self._goals: dict[str, Goal] = {}

    def add_statuses(self, array: Any) -> None:
        """Process an actionlib_msgs/GoalStatusArray."""
        for status in array.status_list[-MAX_GOALS:]:
            self._update_goal(status).num_missed = 0
        listed_ids = {status.goal_id.id for status in array.status_list}
        for goal in self._goals.values():
            if goal.id not in listed_ids and goal.num_missed is not None:
                goal.num_missed += 1
                if goal.num_missed >= _MAX_MISSED and goal.status in _ACTIVE_STATUSES:
                    goal.status = LOST

    def add_feedback(self, message: Any) -> None:
        """Process a message from the feedback topic."""
        goal = self._update_goal(message.status)
        goal.feedback = message.feedback
        goal.num_feedbacks += 1

    def add_result(self, message: Any) -> None:
        """Process a message from the result topic."""
        self._update_goal(message.status).result = message.result

    def all(self) -> list[Goal]:
        """Return the goals, newest first."""
        return sorted(self._goals.values(), key=lambda goal: goal.stamp, reverse=True)

    def _update_goal(self, status: Any) -> Goal:
        goal_id = status.goal_id.id
        goal = self._goals.get(goal_id)
        if goal is None:
            if len(self._goals) >= MAX_GOALS:
                del self._goals[min(self._goals.values(), key=lambda other: other.stamp).id]
            goal = self._goals[goal_id] = Goal(goal_id)
        goal.stamp, goal.status = status.goal_id.stamp.to_sec(), status.status
        goal.text = status.text[:500]
        return goal
