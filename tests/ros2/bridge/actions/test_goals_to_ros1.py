"""The goals that clients in ROS 2 send to an action server in ROS 1."""

from __future__ import annotations

import random
from typing import Any

import pytest

from pyros1.actions.states import Status, Transition, status_after
from pyros1.ros2.bridge.actions import goals_to_ros1
from pyros1.ros2.bridge.actions.goals_to_ros1 import (
    ACCEPT_TIME,
    KEEP_TIME,
    MAX_GOALS,
    MAX_WAITING,
    PENDING_TIME,
    REPORT_TIME,
    RESULT_TIME,
    AnswerCancel,
    AnswerGoal,
    AnswerResult,
    EndWithoutResponse,
    GoalsToRos1,
    SendCancel,
    SendFeedback,
    SendGoal,
    SendStatuses,
    Step,
)
from pyros1.ros2.bridge.actions.ros1_messages import NO_STAMP, GoalStatus
from pyros1.ros2.bridge.actions.ros2_messages import NO_UUID, CancelCode, GoalInfo, ReportedGoal, Ros2Status

UUID = bytes(range(1, 17))
OTHER = UUID[::-1]
STAMP = (5, 6)


def status(status: Status, uuid: bytes = UUID, stamp: tuple[int, int] = STAMP) -> GoalStatus:
    return GoalStatus(uuid.hex(), stamp, int(status))


def accepted(uuid: bytes = UUID) -> GoalsToRos1:
    """Return goals with one that is accepted."""
    goals = GoalsToRos1()
    goals.on_goal("goal", uuid, b"", 0.0)
    assert AnswerGoal("goal", True, STAMP) in goals.on_statuses([status(Status.ACTIVE, uuid)], 0.0)
    return goals


def test_a_goal_that_succeeds() -> None:
    goals = GoalsToRos1()
    assert goals.on_goal("goal", UUID, b"body", 0.0) == [SendGoal(UUID.hex(), b"body")]
    assert goals.on_statuses([status(Status.PENDING)], 0.1) == [], "it may still be rejected"
    reported = (ReportedGoal(GoalInfo(UUID, STAMP), Ros2Status.EXECUTING),)
    assert goals.on_statuses([status(Status.ACTIVE)], 0.2) == [AnswerGoal("goal", True, STAMP), SendStatuses(reported)]
    assert goals.on_statuses([status(Status.ACTIVE)], 0.3) == [], "it is reported already"
    assert goals.on_result_request("result", UUID) == []
    assert goals.on_feedback(status(Status.ACTIVE), b"half", 0.4) == [SendFeedback(UUID, b"half")]
    end = goals.on_result(status(Status.SUCCEEDED), b"done", 0.5)
    assert end[0] == AnswerResult("result", Ros2Status.SUCCEEDED, b"done")
    assert goals.on_result_request("again", UUID) == [AnswerResult("again", Ros2Status.SUCCEEDED, b"done")]
    assert goals.on_feedback(status(Status.ACTIVE), b"late", 0.6) == []
    assert goals.close() == [], "all calls have been answered"


@pytest.mark.parametrize("refused", [Status.REJECTED, Status.RECALLED])
@pytest.mark.parametrize("with_result", [True, False])
def test_a_goal_that_is_refused(refused: Status, with_result: bool) -> None:
    goals = GoalsToRos1()
    goals.on_goal("goal", UUID, b"", 0.0)
    goals.on_result_request("early", UUID)
    reported = status(refused)
    steps = goals.on_result(reported, b"", 0.1) if with_result else goals.on_statuses([reported], 0.1)
    assert steps == [AnswerGoal("goal", False, STAMP), AnswerResult("early", Ros2Status.UNKNOWN, None)]
    assert goals.on_statuses([reported], 0.2) == [], "it is no goal in ROS 2"


def test_a_goal_that_waits_counts_as_accepted_after_a_while() -> None:
    goals = GoalsToRos1()
    goals.on_goal("goal", UUID, b"", 0.0)
    goals.on_statuses([status(Status.PENDING)], 0.0)
    assert goals.tick(PENDING_TIME / 2) == []
    assert AnswerGoal("goal", True, STAMP) in goals.tick(PENDING_TIME)
    goals.on_result_request("result", UUID)
    assert AnswerResult("result", Ros2Status.CANCELED, b"") in goals.on_result(status(Status.RECALLED), b"", 3.0)


def test_a_goal_that_the_server_does_not_report() -> None:
    goals = GoalsToRos1()
    goals.on_goal("goal", UUID, b"", 0.0)
    assert goals.on_statuses([], 1.0) == []
    assert goals.tick(ACCEPT_TIME - 0.1) == []
    assert goals.tick(ACCEPT_TIME) == [SendCancel(UUID.hex(), NO_STAMP), AnswerGoal("goal", False, NO_STAMP)]


def test_a_server_that_has_been_restarted() -> None:
    goals = accepted()
    goals.on_result_request("result", UUID)
    assert AnswerResult("result", Ros2Status.ABORTED, None) in goals.on_statuses([], 1.0)


def test_feedback_before_the_status_does_not_mean_a_restart() -> None:
    goals = GoalsToRos1()
    goals.on_goal("goal", UUID, b"", 0.0)
    assert goals.on_feedback(status(Status.ACTIVE), b"", 0.1)[0] == AnswerGoal("goal", True, STAMP)
    goals.on_result_request("result", UUID)
    assert goals.on_statuses([], 0.2) == [], "it was published before"
    assert AnswerResult("result", Ros2Status.SUCCEEDED, b"r") in goals.on_result(status(Status.SUCCEEDED), b"r", 0.3)


@pytest.mark.parametrize(
    ("final", "end"),
    [
        (Status.SUCCEEDED, Ros2Status.ABORTED),
        (Status.PREEMPTED, Ros2Status.CANCELED),
        (Status.ABORTED, Ros2Status.ABORTED),
    ],
)
def test_a_result_that_does_not_come(final: Status, end: Ros2Status) -> None:
    goals = accepted()
    goals.on_result_request("result", UUID)
    goals.on_statuses([status(final)], 1.0)
    goals.on_statuses([], 2.0)  # forgotten by the server
    assert goals.tick(1.0 + RESULT_TIME - 0.1) == []
    assert AnswerResult("result", end, None) in goals.tick(1.0 + RESULT_TIME)


def test_ids_that_are_not_accepted() -> None:
    goals = accepted()
    for uuid in (UUID, NO_UUID):
        assert goals.on_goal("again", uuid, b"", 0.0) == [AnswerGoal("again", False, NO_STAMP)]
    assert goals.on_result_request("x", OTHER) == [AnswerResult("x", Ros2Status.UNKNOWN, None)]


def test_cancel() -> None:
    goals = accepted()
    here, mine = GoalStatus("/node-1", (3, 0), int(Status.ACTIVE)), status(Status.ACTIVE)
    (statuses,) = goals.on_statuses([mine, here], 1.0)
    assert isinstance(statuses, SendStatuses)
    theirs = statuses.goals[1].info
    assert theirs.stamp == (3, 0) and statuses.goals[0].info == GoalInfo(UUID, STAMP)

    def cancel(uuid: bytes, stamp: tuple[int, int] = NO_STAMP) -> tuple[Any, ...]:
        return tuple(goals.on_cancel("cancel", GoalInfo(uuid, stamp)))

    def answer(*infos: GoalInfo) -> AnswerCancel:
        return AnswerCancel("cancel", CancelCode.NONE, infos)

    both = (GoalInfo(UUID, STAMP), theirs)
    assert cancel(UUID) == (SendCancel(UUID.hex(), NO_STAMP), answer(both[0]))
    assert cancel(theirs.uuid) == (SendCancel("/node-1", NO_STAMP), answer(theirs))
    assert cancel(NO_UUID) == (SendCancel("", NO_STAMP), answer(*both))
    assert cancel(NO_UUID, (4, 0)) == (SendCancel("", (4, 0)), answer(theirs))
    assert cancel(UUID, (4, 0)) == (SendCancel(UUID.hex(), (4, 0)), answer(*both))
    assert cancel(OTHER) == (AnswerCancel("cancel", CancelCode.UNKNOWN_GOAL, ()),)
    goals.on_result(status(Status.SUCCEEDED), b"", 2.0)
    assert cancel(UUID) == (AnswerCancel("cancel", CancelCode.ENDED, ()),)


def test_statuses_after_the_end() -> None:
    goals = accepted()
    ended = SendStatuses((ReportedGoal(GoalInfo(UUID, STAMP), Ros2Status.CANCELED),))
    assert goals.on_result(status(Status.PREEMPTED), b"", 1.0) == [ended]
    assert goals.on_statuses([status(Status.PREEMPTED)], 2.0) == []
    assert goals.on_statuses([], 3.0) == []
    assert goals.tick(1.0 + REPORT_TIME + 0.1) == [SendStatuses(())]


def test_everything_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    goals = accepted()
    for number in range(MAX_WAITING):
        assert goals.on_result_request(number, UUID) == []
    assert isinstance(goals.on_result_request("more", UUID)[0], EndWithoutResponse)
    monkeypatch.setattr(goals_to_ros1, "MAX_RESULTS", 3)
    monkeypatch.setattr(goals_to_ros1, "MAX_RESULT_BYTES", 10)
    goals = GoalsToRos1()
    uuids = [bytes([number]) * 16 for number in range(1, 7)]
    for uuid in uuids:
        goals.on_goal("goal", uuid, b"", 0.0)
        goals.on_result(status(Status.SUCCEEDED, uuid), b"12345", 0.0)
    found = [goals.on_result_request("x", uuid)[0] for uuid in uuids]
    known = [isinstance(each, AnswerResult) and each.status is Ros2Status.SUCCEEDED for each in found]
    assert known == [False] * 4 + [True] * 2
    goals.tick(KEEP_TIME + 1)
    assert goals.on_result_request("x", uuids[-1]) == [AnswerResult("x", Ros2Status.UNKNOWN, None)]


def test_too_many_goals() -> None:
    goals = GoalsToRos1()
    uuids = [number.to_bytes(16, "big") for number in range(1, MAX_GOALS + 2)]
    sent = [goals.on_goal("goal", uuid, b"", 0.0)[0] for uuid in uuids]
    assert all(isinstance(each, SendGoal) for each in sent[:-1])
    assert sent[-1] == AnswerGoal("goal", False, NO_STAMP)


def test_the_end_of_the_server_and_of_the_bridge() -> None:
    goals = accepted()
    goals.on_goal("second", OTHER, b"", 0.0)
    goals.on_result_request("result", UUID)
    steps = goals.on_lost(1.0)
    assert AnswerGoal("second", False, NO_STAMP) in steps and AnswerResult("result", Ros2Status.ABORTED, None) in steps
    goals = accepted()
    goals.on_goal("second", OTHER, b"", 0.0)
    goals.on_result_request("result", UUID)
    assert {step.call for step in goals.close() if isinstance(step, EndWithoutResponse)} == {"second", "result"}


class Ros1Server:
    """A server that does at random what one may do."""

    def __init__(self, chance: random.Random) -> None:
        self.chance = chance
        self.goals: dict[str, Status] = {}

    def take(self, step: Step) -> None:
        if isinstance(step, SendGoal) and self.chance.random() < 0.9:
            self.goals.setdefault(step.name, Status.PENDING)
        elif isinstance(step, SendCancel):
            for name, now in self.goals.items():
                if step.name in ("", name):
                    self.goals[name] = status_after(now, Transition.ASK_TO_CANCEL) or now

    def say(self) -> tuple[str, Any]:
        chance = self.chance
        active = [name for name, now in self.goals.items() if not now.ended]
        if not active or chance.random() < 0.4:
            return "statuses", [GoalStatus(name, STAMP, int(now)) for name, now in self.goals.items()]
        name = chance.choice(active)
        transition = chance.choice([each for each in Transition if each is not Transition.ASK_TO_CANCEL])
        self.goals[name] = status_after(self.goals[name], transition) or self.goals[name]
        if self.goals[name].ended:
            reported = GoalStatus(name, STAMP, int(self.goals[name]))
            return ("result", reported) if chance.random() < 0.9 else self.say()
        return "feedback", GoalStatus(name, STAMP, int(self.goals[name]))


@pytest.mark.parametrize("seed", range(40))
def test_random(seed: int) -> None:
    chance = random.Random(seed)
    goals, server = GoalsToRos1(), Ros1Server(chance)
    unanswered: set[object] = set()
    accepted: dict[bytes, bool] = {}
    calls: dict[object, bytes] = {}
    results: dict[bytes, set[tuple[Ros2Status, bytes | None]]] = {}
    waiting: list[tuple[str, Any]] = []  # messages may overtake those of other topics
    now, number = 0.0, 0

    def do(steps: list[Step]) -> None:
        for step in steps:
            server.take(step)
            call = getattr(step, "call", None)
            if call is not None:
                assert call in unanswered, "nothing is answered twice"
                unanswered.discard(call)
            if isinstance(step, AnswerGoal):
                accepted[calls[call]] = accepted.get(calls[call], False) or step.accepted
            elif isinstance(step, AnswerResult) and step.status is not Ros2Status.UNKNOWN:
                assert step.status.ended and accepted[calls[call]]
                results.setdefault(calls[call], set()).add((step.status, step.result))

    for _ in range(400):
        now += chance.random() * 0.5
        kind = chance.randrange(8)
        uuid = bytes([chance.randrange(1, 30)]) * 16
        if kind < 3:
            number += 1
            unanswered.add(number)
            calls[number] = uuid
            if kind == 0:
                do(goals.on_goal(number, uuid, b"", now))
            elif kind == 1:
                do(goals.on_result_request(number, uuid))
            else:
                do(goals.on_cancel(number, GoalInfo(uuid if chance.random() < 0.9 else NO_UUID)))
        elif kind == 3:
            do(goals.tick(now))
        elif kind == 4 and chance.random() < 0.05:
            server.goals.clear()  # it is restarted
        else:
            waiting.append(server.say())
            kinds = {each[0] for each in waiting}
            if chance.random() < 0.8:
                chosen = chance.choice(sorted(kinds))
                topic, what = waiting.pop(next(at for at, each in enumerate(waiting) if each[0] == chosen))
                if topic == "statuses":
                    do(goals.on_statuses(what, now))
                else:
                    do((goals.on_feedback if topic == "feedback" else goals.on_result)(what, b"x", now))
    do(goals.tick(now + ACCEPT_TIME + RESULT_TIME))
    do(goals.on_lost(now + 20))
    assert not unanswered, "everything is answered"
    assert all(len(each) == 1 for each in results.values()), "a goal ends once"


def test_goals_that_come_after_the_server_is_gone() -> None:
    goals = accepted()
    goals.on_lost(1.0)
    assert goals.on_goal("late", OTHER, b"", 1.1) == [AnswerGoal("late", False, NO_STAMP)]
    assert goals.on_result_request("result", OTHER) == [AnswerResult("result", Ros2Status.UNKNOWN, None)]
    assert goals.close() == [], "nobody would answer it"
