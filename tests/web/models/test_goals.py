"""Goals as an action's topics tell of them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from pyros1.ground.timing import Time
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from pyros1.web.models.goals import MAX_GOALS, Goals


def status(name: str, secs: int = 1, state: int = 1, text: str = "") -> Any:
    return GoalStatus(goal_id=GoalID(stamp=Time(secs, 0), id=name), status=state, text=text)


def test_goals_are_collected() -> None:
    goals = Goals()
    goals.add_statuses(GoalStatusArray(status_list=[status("a"), status("b", 2)]))
    goals.add_feedback(SimpleNamespace(status=status("a"), feedback="f"))
    goals.add_result(SimpleNamespace(status=status("a", state=3, text="good"), result="r"))
    newest, oldest = goals.all()
    assert (newest.id, newest.stamp, newest.status) == ("b", 2.0, 1)
    assert (oldest.status, oldest.text, oldest.feedback, oldest.num_feedbacks, oldest.result) == (
        3,
        "good",
        "f",
        1,
        "r",
    )


def test_goals_that_their_server_does_not_know_any_more_are_lost() -> None:
    goals = Goals()
    listed = [status("a"), status("b", 2), status("done", 3, state=3)]
    goals.add_statuses(GoalStatusArray(status_list=listed))
    goals.add_feedback(SimpleNamespace(status=status("new", 4), feedback="f"))  # before a list has it
    goals.add_statuses(GoalStatusArray(status_list=[status("b", 2)]))  # it may be older than that
    goals.add_statuses(GoalStatusArray(status_list=[status("b", 2)]))  # the server was started again
    assert {goal.id: goal.status for goal in goals.all()} == {"a": 9, "b": 1, "done": 3, "new": 1}
    goals.add_statuses(GoalStatusArray(status_list=[status("a")]))
    assert {goal.id: goal.status for goal in goals.all()} == {"a": 1, "b": 1, "done": 3, "new": 1}


def test_the_oldest_are_forgotten() -> None:
    goals = Goals()
    for number in range(MAX_GOALS * 2):
        goals.add_statuses(GoalStatusArray(status_list=[status(str(number), number + 1)]))
    assert [goal.id for goal in goals.all()] == [str(number) for number in reversed(range(MAX_GOALS, MAX_GOALS * 2))]
    goals.add_statuses(GoalStatusArray(status_list=[status(f"x{number}", 1000) for number in range(MAX_GOALS * 5)]))
    assert len(goals.all()) == MAX_GOALS
