"""The goals that clients in ROS 1 send to an action server in ROS 2."""

from __future__ import annotations

import random
from itertools import count
from typing import Any

import pytest

from pyros1.actions.progress import Progress
from pyros1.actions.states import Status
from pyros1.ros2.bridge.actions import goals_to_ros2
from pyros1.ros2.bridge.actions.goals_to_ros2 import (
    KEEP_TIME,
    LONG_TIME,
    MAX_EARLY,
    MAX_GOALS,
    MAX_RETRIES,
    RESULT_TIME,
    RETRY_TIME,
    STATUS_PERIOD,
    CallCancel,
    CallGoal,
    CallResult,
    GoalsToRos2,
    PublishFeedback,
    PublishResult,
    PublishStatuses,
    Step,
)
from pyros1.ros2.bridge.actions.ros1_messages import NO_STAMP, GoalStatus
from pyros1.ros2.bridge.actions.ros2_messages import GoalInfo, ReportedGoal, Ros2Status

STAMP, NOW = (5, 0), (7, 0)
FIRST = (1).to_bytes(16, "big")


def make_goals() -> GoalsToRos2:
    numbers = count(1)
    return GoalsToRos2(lambda: next(numbers).to_bytes(16, "big"))


def active(name: str = "goal") -> GoalsToRos2:
    """Return goals with one that is active."""
    goals = make_goals()
    goals.on_goal(name, STAMP, b"body", 0.0, NOW)
    assert CallResult(FIRST) in goals.on_goal_response(FIRST, True, "", 0.0)
    return goals


def result_of(steps: list[Step]) -> PublishResult:
    (found,) = [step for step in steps if isinstance(step, PublishResult)]
    return found


def statuses_of(steps: list[Step]) -> list[Status]:
    return [Status(each.status) for step in steps if isinstance(step, PublishStatuses) for each in step.statuses]


def test_a_goal_that_succeeds() -> None:
    goals = make_goals()
    steps = goals.on_goal("goal", STAMP, b"body", 0.0, NOW)
    assert steps == [CallGoal(FIRST, b"body"), PublishStatuses((GoalStatus("goal", STAMP, Status.PENDING),))]
    assert goals.on_goal("goal", STAMP, b"body", 0.0, NOW) == [], "it is known"
    running = GoalStatus("goal", STAMP, Status.ACTIVE)
    assert goals.on_goal_response(FIRST, True, "", 0.1) == [CallResult(FIRST), PublishStatuses((running,))]
    assert goals.on_goal_response(FIRST, False, "", 0.1) == [], "it has responded"
    assert goals.on_feedback(FIRST, b"half") == [PublishFeedback(running, b"half")]
    done = GoalStatus("goal", STAMP, Status.SUCCEEDED)
    end = goals.on_result(FIRST, Ros2Status.SUCCEEDED, b"done", "", 0.2)
    assert end == [PublishResult(done, b"done"), PublishStatuses((done,))]
    assert goals.on_feedback(FIRST, b"late") == []
    assert goals.on_result(FIRST, Ros2Status.ABORTED, b"", "", 0.3) == []
    assert statuses_of(goals.tick(0.2 + KEEP_TIME)) == [Status.SUCCEEDED]
    assert goals.tick(0.4 + KEEP_TIME)[-1:] == [PublishStatuses(())]


def test_statuses_are_repeated() -> None:
    goals = active()
    assert goals.tick(STATUS_PERIOD / 2) == []
    assert statuses_of(goals.tick(STATUS_PERIOD)) == [Status.ACTIVE]
    assert goals.tick(STATUS_PERIOD * 1.5) == []


def test_names_and_stamps_that_are_empty() -> None:
    (call, statuses) = make_goals().on_goal("", NO_STAMP, b"", 0.0, NOW)
    assert isinstance(call, CallGoal) and isinstance(statuses, PublishStatuses)
    assert statuses.statuses == (GoalStatus(call.uuid.hex(), NOW, Status.PENDING),)


@pytest.mark.parametrize(
    ("accepted", "text", "end"), [(False, "", Status.REJECTED), (None, "no response", Status.ABORTED)]
)
def test_a_goal_that_is_not_accepted(accepted: bool | None, text: str, end: Status) -> None:
    goals = make_goals()
    goals.on_goal("goal", STAMP, b"", 0.0, NOW)
    steps = goals.on_goal_response(FIRST, accepted, text, 1.0)
    assert result_of(steps).status.status == end and text in result_of(steps).status.text
    assert (CallCancel(FIRST) in steps) is (accepted is None)
    assert goals.on_goal_response(FIRST, True, "", 2.0) == [CallCancel(FIRST)], "its client thinks that it has ended"


@pytest.mark.parametrize(
    ("status", "end"),
    [
        (Ros2Status.SUCCEEDED, Status.SUCCEEDED),
        (Ros2Status.CANCELED, Status.PREEMPTED),
        (Ros2Status.ABORTED, Status.ABORTED),
        (Ros2Status.UNKNOWN, Status.ABORTED),
        (Ros2Status.EXECUTING, Status.ABORTED),
        (-1, Status.ABORTED),
        (99, Status.ABORTED),
    ],
)
def test_how_goals_end(status: int, end: Status) -> None:
    assert result_of(active().on_result(FIRST, status, b"", "", 1.0)).status.status == end


def test_cancel() -> None:
    goals = active()
    assert goals.on_cancel("goal", NO_STAMP, 1.0) == [CallCancel(FIRST)]
    assert goals.on_cancel_response(FIRST, [], 1.1) == [], "the server does not want to"
    assert goals.on_cancel("", STAMP, 1.2) == [CallCancel(FIRST)]
    assert statuses_of(goals.on_cancel_response(FIRST, [GoalInfo(FIRST)], 1.3)) == [Status.PREEMPTING]
    assert goals.on_cancel("", NO_STAMP, 1.4) == [], "it does already"
    assert active().on_cancel("", (4, 9), 1.0) == [], "it is later"
    assert active().on_cancel("", NO_STAMP, 1.0) == [CallCancel(FIRST)]
    assert active().on_cancel("other", STAMP, 1.0) == [CallCancel(FIRST)]


def test_a_goal_that_is_cancelled_before_it_is_accepted() -> None:
    goals = make_goals()
    goals.on_goal("goal", STAMP, b"", 0.0, NOW)
    assert statuses_of(goals.on_cancel("goal", NO_STAMP, 0.1)) == [Status.RECALLING]
    steps = goals.on_goal_response(FIRST, True, "", 0.2)
    assert steps[:2] == [CallResult(FIRST), CallCancel(FIRST)] and statuses_of(steps) == [Status.PREEMPTING]


def test_goals_that_are_cancelled_before_they_come() -> None:
    goals = make_goals()
    goals.on_cancel("goal", NO_STAMP, 0.0)
    steps = goals.on_goal("goal", STAMP, b"", 1.0, NOW)
    assert result_of(steps).status.status == Status.RECALLED and not any(isinstance(each, CallGoal) for each in steps)
    goals.on_cancel("", (10, 0), 1.0)
    assert result_of(goals.on_goal("old", STAMP, b"", 1.0, NOW)).status.status == Status.RECALLED
    assert isinstance(goals.on_goal("new", (11, 0), b"", 1.0, NOW)[0], CallGoal)
    goals.on_cancel("much later", NO_STAMP, 1.0)
    goals.tick(1.1 + KEEP_TIME)
    assert isinstance(goals.on_goal("much later", (11, 0), b"", 9.0, NOW)[0], CallGoal)
    for number in range(MAX_EARLY + 1):
        goals.on_cancel(str(number), NO_STAMP, 9.0)
    assert isinstance(goals.on_goal("0", (11, 0), b"", 9.0, NOW)[0], CallGoal), "it was too long ago"


def test_goals_of_ros2s_own_clients() -> None:
    goals = active()
    other = ReportedGoal(GoalInfo(bytes(15) + b"\xff", (1, 0)), Ros2Status.EXECUTING)
    steps = goals.on_statuses([ReportedGoal(GoalInfo(FIRST), Ros2Status.EXECUTING), other], 1.0)
    assert statuses_of(steps) == [Status.ACTIVE, Status.ACTIVE]
    name = other.info.uuid.hex()
    assert goals.on_goal(name, STAMP, b"", 1.0, NOW) == []
    assert goals.on_cancel(name, NO_STAMP, 1.0) == [CallCancel(other.info.uuid)]
    assert goals.on_cancel("", NO_STAMP, 1.0) == [CallCancel(FIRST), CallCancel(other.info.uuid)]
    assert goals.on_feedback(other.info.uuid, b"") == []


def test_a_result_that_does_not_come() -> None:
    goals = active()
    goals.on_statuses([ReportedGoal(GoalInfo(FIRST), Ros2Status.SUCCEEDED)], 1.0)
    assert not any(isinstance(each, PublishResult) for each in goals.tick(0.9 + RESULT_TIME))
    assert result_of(goals.tick(1.0 + RESULT_TIME)).status.status == Status.ABORTED


def test_requests_for_results_that_fail() -> None:
    goals = active()
    now = LONG_TIME
    goals.on_result(FIRST, None, b"", "no response", now)
    for _ in range(MAX_RETRIES + 1):
        assert CallResult(FIRST) not in goals.tick(now + RETRY_TIME / 2)
        now += RETRY_TIME
        assert CallResult(FIRST) in goals.tick(now)
        steps = goals.on_result(FIRST, None, b"", "no response", now)
    assert result_of(steps).status == GoalStatus("goal", STAMP, Status.ABORTED, "no response")


def test_the_server_is_gone() -> None:
    goals = active()
    goals.on_goal("second", STAMP, b"", 0.0, NOW)
    steps = goals.on_lost("gone", 1.0)
    assert [step.status.text for step in steps if isinstance(step, PublishResult)] == ["gone", "gone"]
    assert statuses_of(steps) == [Status.ABORTED, Status.ABORTED]


def test_too_many_goals() -> None:
    goals = make_goals()
    for number in range(MAX_GOALS):
        assert isinstance(goals.on_goal(f"{number}", STAMP, b"", 0.0, NOW)[0], CallGoal)
    (refused,) = goals.on_goal("more", STAMP, b"", 0.0, NOW)
    assert isinstance(refused, PublishResult) and refused.status.status == Status.REJECTED
    goals = make_goals()
    for number in range(MAX_GOALS):  # results that never come, though the server says that the goals have ended
        goals.on_goal(f"{number}", STAMP, b"", 0.0, NOW)
        goals.on_goal_response((number + 1).to_bytes(16, "big"), True, "", 0.0)
    goals.on_lost("", 0.0)
    assert result_of(goals.on_goal("more", STAMP, b"", 0.0, NOW)).status.status == Status.REJECTED
    goals.on_result(FIRST, None, b"", "", 0.0)
    assert isinstance(goals.on_goal("more", STAMP, b"", 0.0, NOW)[0], CallGoal)


def test_many_goals_that_have_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(goals_to_ros2, "MAX_ENDED", 10)
    goals = make_goals()
    for number in range(15):
        goals.on_goal(f"{number}", STAMP, b"", 0.0, NOW)
        goals.on_goal_response((number + 1).to_bytes(16, "big"), False, "", 0.0)
    assert len(statuses_of(goals.tick(STATUS_PERIOD))) == 10


@pytest.mark.parametrize("seed", range(40))
def test_random(seed: int) -> None:
    chance = random.Random(seed)
    goals = make_goals()
    violations: list[str] = []
    clients: dict[str, Progress] = {}
    results: dict[str, int] = {}
    calls: list[Step] = []
    there: dict[bytes, Ros2Status] = {}  # the goals of the server
    messages: list[tuple[str, Any]] = []
    now = 0.0

    def do(steps: list[Step]) -> None:
        for step in steps:
            if isinstance(step, PublishStatuses):
                messages.append(("status", step.statuses))
            elif isinstance(step, PublishResult):
                results[step.status.name] = results.get(step.status.name, 0) + 1
                messages.append(("result", step.status))
            elif not isinstance(step, PublishFeedback):
                calls.append(step)

    def answer(call: Step) -> None:
        fails = chance.random() < 0.05
        if isinstance(call, CallGoal):
            accepted = chance.random() < 0.8
            if accepted:
                there[call.uuid] = Ros2Status.EXECUTING
            do(goals.on_goal_response(call.uuid, None if fails else accepted, "", now))
        elif isinstance(call, CallCancel):
            if there.get(call.uuid) is Ros2Status.EXECUTING and chance.random() < 0.7:
                there[call.uuid] = Ros2Status.CANCELING
                do(goals.on_cancel_response(call.uuid, [GoalInfo(call.uuid)], now))
            else:
                do(goals.on_cancel_response(call.uuid, [], now))
        elif isinstance(call, CallResult):
            status = there.get(call.uuid, Ros2Status.UNKNOWN)
            if fails:
                do(goals.on_result(call.uuid, None, b"", "", now))
            elif status.ended or status is Ros2Status.UNKNOWN:
                do(goals.on_result(call.uuid, status, b"", "", now))
            else:
                calls.append(call)

    def deliver() -> None:
        """Deliver the next message of a topic: those of one can overtake those of the other."""
        topic = chance.choice(sorted({each[0] for each in messages}))
        _, what = messages.pop(next(at for at, each in enumerate(messages) if each[0] == topic))
        if topic == "status":
            for progress in clients.values():
                progress.handle_statuses({each.name: each for each in what})
        elif what.name in clients:
            clients[what.name].handle_result(what, b"")

    for number in range(400):
        now += chance.random() * 0.2
        kind = chance.randrange(7)
        if kind == 0:
            name = f"goal {number}"
            clients[name] = Progress(name, lambda _: None, violations.append)
            do(goals.on_goal(name, (number + 1, 0), b"", now, NOW))
        elif kind == 1 and clients:
            name = chance.choice(sorted(clients))
            clients[name].ask_to_cancel()
            do(goals.on_cancel(name, NO_STAMP, now))
        elif kind == 2 and calls:
            answer(calls.pop(chance.randrange(len(calls))))
        elif kind == 3 and there:
            uuid = chance.choice(sorted(there))
            if not there[uuid].ended:
                there[uuid] = Ros2Status(chance.choice([there[uuid], 4, 6, 5]))
        elif kind == 4:
            do(goals.on_statuses([ReportedGoal(GoalInfo(uuid), status) for uuid, status in there.items()], now))
        elif kind == 5:
            do(goals.tick(now))
        while messages and chance.random() < 0.7:
            deliver()
    do(goals.on_lost("gone", now))
    while messages:
        deliver()
    assert violations == []
    assert {*results} == {*clients} and {*results.values()} <= {1}, "each goal has one result"
    assert all(each.done for each in clients.values())
