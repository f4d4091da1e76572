"""The pure parts of actions: one goal between a client and a server, whatever gets lost or late."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from pyros1.actions.goal_id import GoalNames, cancel_request_matches
from pyros1.actions.goal_table import GoalTable, Tracked
from pyros1.actions.progress import Progress
from pyros1.actions.states import Stage, Status, Transition, stages_after, status_after
from pyros1.ground.timing import Duration, Time

FOLLOWING = {
    Stage.WAITING_FOR_GOAL_ACK: {Stage.PENDING, Stage.ACTIVE, Stage.WAITING_FOR_CANCEL_ACK, Stage.DONE},
    Stage.PENDING: {
        Stage.ACTIVE,
        Stage.RECALLING,
        Stage.WAITING_FOR_RESULT,
        Stage.WAITING_FOR_CANCEL_ACK,
        Stage.DONE,
    },
    Stage.ACTIVE: {Stage.PREEMPTING, Stage.WAITING_FOR_RESULT, Stage.WAITING_FOR_CANCEL_ACK, Stage.DONE},
    Stage.WAITING_FOR_CANCEL_ACK: {
        Stage.RECALLING,
        Stage.PREEMPTING,
        Stage.WAITING_FOR_RESULT,
        Stage.WAITING_FOR_CANCEL_ACK,
        Stage.DONE,
    },
    Stage.RECALLING: {Stage.PREEMPTING, Stage.WAITING_FOR_RESULT, Stage.DONE},
    Stage.PREEMPTING: {Stage.WAITING_FOR_RESULT, Stage.DONE},
    Stage.WAITING_FOR_RESULT: {Stage.DONE},
    Stage.DONE: set(),
}
"""What may follow each stage, by the diagram of https://wiki.ros.org/actionlib/DetailedDescription."""


def goal_id(name: str = "", seconds: float = 0) -> Any:
    return SimpleNamespace(id=name, stamp=Time.from_sec(seconds))


class OneGoal(RuleBasedStateMachine):
    """A server's goal and its client; messages come in order on each topic, but not between topics, or not at all."""

    def __init__(self) -> None:
        super().__init__()
        self.server = Tracked(SimpleNamespace(id="g", stamp=Time(1)), goal=object())
        self.server.status = SimpleNamespace(status=0, text="", goal_id=self.server.status.goal_id)
        self.stages: list[Stage] = [Stage.WAITING_FOR_GOAL_ACK]
        self.oddities: list[str] = []
        self.client = Progress("g", self.stages.append, self.oddities.append)
        self.said: list[Any] = []
        self.ended: Any = None
        self.newest = 0

    def say(self) -> None:
        status = SimpleNamespace(status=self.server.status.status, text=self.server.status.text)
        self.said.append(status)
        if Status(status.status).ended:
            self.ended_at = status

    @rule(move=st.sampled_from(list(Transition)))
    def server_moves(self, move: Transition) -> None:
        before = self.server.status.status
        moved = self.server.apply(move, move.value)
        assert moved == (status_after(before, move) is not None)
        assert not (moved and Status(before).ended)
        if moved:
            self.say()

    @precondition(lambda self: self.said)
    @rule(skipped=st.integers(0, 3))
    def status_comes(self, skipped: int) -> None:
        self.newest = min(self.newest + skipped, len(self.said) - 1)
        self.client.handle_statuses({"g": self.said[self.newest]})

    @precondition(lambda self: self.ended is not None)
    @rule()
    def result_comes(self) -> None:
        first = not self.client.done
        self.client.handle_result(self.ended, "result")
        assert self.client.done
        assert self.client.result == "result"
        if first:
            assert self.client.status == self.ended.status

    @rule()
    def client_cancels(self) -> None:
        before = self.client.stage
        helps = self.client.ask_to_cancel()
        assert helps == (before not in (Stage.DONE, Stage.WAITING_FOR_RESULT))

    @invariant()
    def stages_follow_the_diagram(self) -> None:
        for stage, following in zip(self.stages, self.stages[1:], strict=False):
            assert following in FOLLOWING[stage], self.stages
        assert self.client.stage is self.stages[-1]
        assert self.stages.count(Stage.DONE) <= 1


TestOneGoal = OneGoal.TestCase
TestOneGoal.settings = settings(max_examples=60, stateful_step_count=20, deadline=None)


@pytest.mark.parametrize("stage", list(Stage))
@pytest.mark.parametrize("status", [status for status in Status if status.ended and status is not Status.LOST])
def test_every_end_leads_to_the_result(stage: Stage, status: Status) -> None:
    stages = stages_after(stage, status)
    if stages:
        assert stages[-1] is Stage.WAITING_FOR_RESULT
    elif stages is None:
        assert status in (Status.REJECTED, Status.RECALLED)  # of goals that the server had accepted


def test_unknown_statuses_are_odd() -> None:
    assert stages_after(Stage.ACTIVE, 77) is None
    assert stages_after(Stage.DONE, Status.ACTIVE) is None
    assert status_after(77, Transition.ACCEPT) is None
    assert status_after(-1, Transition.ACCEPT) is None


def test_a_goal_that_the_server_forgets_is_lost() -> None:
    progress = Progress("g", lambda _: None)
    progress.handle_statuses({})
    assert not progress.done  # it may not have come yet
    assert progress.ask_to_cancel()
    progress.handle_statuses({})
    assert not progress.done
    progress.handle_statuses({"g": SimpleNamespace(status=1, text="on")})
    assert progress.stage is Stage.WAITING_FOR_CANCEL_ACK
    progress.handle_statuses({})
    assert progress.done
    assert progress.status is Status.LOST


def test_a_result_without_an_end_is_odd() -> None:
    oddities: list[str] = []
    progress = Progress("g", lambda _: None, oddities.append)
    progress.handle_result(SimpleNamespace(status=1, text=""), "result")
    assert progress.done
    assert progress.status is Status.LOST
    assert len(oddities) == 1


@pytest.mark.parametrize(
    ("request_id", "matching"),
    [
        (goal_id(), "abc"),
        (goal_id("b"), "b"),
        (goal_id("", 2), "ab"),
        (goal_id("c", 1), "ac"),
        (goal_id("x", 0), ""),
    ],
)
def test_which_goals_a_request_means(request_id: Any, matching: str) -> None:
    goals = [goal_id(name, number) for number, name in enumerate("abc", 1)]
    assert "".join(goal.id for goal in goals if cancel_request_matches(request_id, goal)) == matching


def test_the_table_forgets_goals_some_time_after_their_end() -> None:
    table: GoalTable[Tracked] = GoalTable(Duration(5))
    for name in "ab":
        table.goals.append(Tracked(goal_id(name, 1), goal=object()))
    table.goals[0].ended_at = Time(10)
    assert not table.forget(Time(15))
    assert [each.status.goal_id.id for each in table.forget(Time(16))] == ["a"]
    assert [each.status.goal_id.id for each in table.goals] == ["b"]


def test_a_goal_that_comes_after_its_cancel_is_recalled() -> None:
    table: GoalTable[Tracked] = GoalTable(Duration(5))
    assert table.find_arrived("g", Time(1)) == (None, False)
    early = Tracked(goal_id("g"), Status.RECALLING)
    table.goals.append(early)
    assert table.find_arrived("g", Time(1)) == (early, True)
    assert early.status.status == Status.RECALLED
    assert table.find_arrived("g", Time(1)) == (early, False)
    assert table.match_cancel(goal_id("", 3)) == [early]
    assert table.is_too_old(goal_id("h", 2))
    assert not table.is_too_old(goal_id("h", 4))
    assert not table.is_too_old(goal_id("h", 0))


def test_names_of_goals() -> None:
    names = GoalNames("/node")
    assert names.next(Time(7, 5_000_000)) == "/node-1-7.005"
    assert names.next(Time(7, 5_000_000)) == "/node-2-7.005"


def test_goals_are_forgotten_when_simulated_time_begins_again() -> None:
    table: GoalTable[Tracked] = GoalTable(Duration(5))
    goal = Tracked(goal_id("old", 90), 3)
    goal.ended_at = Time(95, 0)
    table.goals.append(goal)
    table.match_cancel(goal_id("", 99))
    assert table.forget(Time(99, 0)) == []
    assert table.is_too_old(goal_id("new", 98))
    assert table.forget(Time(2, 0)) == []  # the bag is played again
    assert not table.is_too_old(goal_id("new", 3))
    assert table.forget(Time(6, 0)) == []
    assert table.forget(Time(8, 0)) == [goal]
