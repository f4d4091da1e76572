"""Clients and servers of actions in nodes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from pyros1 import actions
from pyros1.actions import ActionError, Client, GoalError, Server, ServerGoal, SimpleServer, Stage, Status
from pyros1.ground.errors import NodeShutdownError, WaitTimeoutError
from pyros1.ground.timing import Duration
from pyros1.msgs.actionlib_tutorials.msg import (
    FibonacciAction,
    FibonacciActionGoal,
    FibonacciFeedback,
    FibonacciGoal,
    FibonacciResult,
)
from pyros1.msgs.std_msgs.msg import String
from pyros1.net.signal_safe import Condition
from pyros1.node import Node

Make = Callable[..., Node]
ACTION = "fibonacci"


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as entered:
        yield entered


def fibonacci(goal: ServerGoal) -> Any:
    sequence = [0, 1]
    for _ in range(1, goal.goal.order):
        sequence.append(sequence[-1] + sequence[-2])
        goal.feedback(FibonacciFeedback(sequence=sequence))
    return FibonacciResult(sequence=sequence)


def until_cancelled(goal: ServerGoal) -> None:
    stop = threading.Event()
    goal.on_cancel(stop.set)
    assert stop.wait(20)
    goal.cancel(FibonacciResult(sequence=[goal.goal.order]), "stopped")


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_a_goal_succeeds(make_node: Make, stack: ExitStack, transport: str, callbacks: str) -> None:
    stack.enter_context(SimpleServer(make_node("server"), ACTION, FibonacciAction, fibonacci))
    node = make_node("client", callbacks=callbacks)
    client = stack.enter_context(Client(node, ACTION, "actionlib_tutorials/Fibonacci"))
    stages: list[Stage] = []
    ended = threading.Event()
    heard: list[Any] = []
    goal = client.send(
        FibonacciGoal(order=5),
        on_feedback=heard.append,
        on_stage=lambda _, stage: stages.append(stage),
        on_done=lambda goal: ended.set(),
        timeout=20,
    )
    assert goal.result(20).sequence == (0, 1, 1, 2, 3, 5)
    assert goal.status is Status.SUCCEEDED
    assert goal.done
    assert ended.wait(20)
    assert stages[-1] is Stage.DONE
    assert Stage.ACTIVE in stages
    assert goal.name.startswith("/client-1-")
    goal.cancel()  # nothing to cancel
    assert goal.stage is Stage.DONE


def test_feedback_comes_to_an_iteration(make_node: Make, stack: ExitStack) -> None:
    go_on = threading.Event()

    def execute(goal: ServerGoal) -> Any:
        for number in range(goal.goal.order):
            goal.feedback(FibonacciFeedback(sequence=[number]))
        assert go_on.wait(20)
        return FibonacciResult()

    stack.enter_context(SimpleServer(make_node("server"), ACTION, FibonacciAction, execute))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    goal = client.send(FibonacciGoal(order=3), timeout=20)
    seen = []
    for message in goal.feedback(timeout=20):
        seen.append(message.sequence)
        if len(seen) == 3:
            go_on.set()
    assert seen == [(0,), (1,), (2,)]
    with pytest.raises(IndexError):
        goal.next_feedback()


def test_a_goal_is_cancelled(make_node: Make, stack: ExitStack) -> None:
    stack.enter_context(SimpleServer(make_node("server"), ACTION, FibonacciAction, until_cancelled))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    active = threading.Event()
    goal = client.send(
        FibonacciGoal(order=7), on_stage=lambda _, stage: stage is Stage.ACTIVE and active.set(), timeout=20
    )
    with pytest.raises(WaitTimeoutError, match="did not finish within"):
        goal.result(0.01)
    assert active.wait(20)  # a goal that has not begun would be recalled
    goal.cancel()
    with pytest.raises(GoalError, match=r"PREEMPTED \(stopped\)") as caught:
        goal.result(20)
    assert caught.value.result.sequence == (7,)


@pytest.mark.parametrize("how", ["all", "until"])
def test_all_goals_are_cancelled(make_node: Make, stack: ExitStack, how: str) -> None:
    node = make_node("server")
    all_came = threading.Barrier(2)

    def on_goal(goal: ServerGoal) -> None:
        goal.accept("go")
        if goal.goal.order == 49:
            all_came.wait(20)

    stack.enter_context(Server(node, ACTION, FibonacciAction, on_goal, lambda goal: goal.cancel()))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    goals = [client.send(FibonacciGoal(order=number), timeout=20) for number in range(50)]
    all_came.wait(20)  # a request for all goals means those that have come
    if how == "all":
        client.cancel_all()
    else:
        client.cancel_until(node.now())
    for goal in goals:
        assert goal.wait(20)
        assert goal.status in (Status.PREEMPTED, Status.RECALLED)
    if how == "until":
        late = client.node.now() - Duration(3600)
        early = node.advertise(f"{ACTION}/goal", FibonacciActionGoal, queue_size=1)
        message = FibonacciActionGoal()
        message.goal_id.id, message.goal_id.stamp = "old", late
        results = []
        came = threading.Event()
        seen = client.node.subscribe(
            f"{ACTION}/result",
            client.types.action_result,
            lambda message: (results.append(message), message.status.goal_id.id == "old" and came.set()),
        )
        assert seen.wait_for_publishers(timeout=20)
        assert early.wait_for_subscribers(timeout=20)
        early.publish(message)
        assert came.wait(20)
        assert results[-1].status.status == Status.RECALLED
        assert "timestamp" in results[-1].status.text


def test_a_newer_goal_takes_the_place_of_an_older_one(make_node: Make, stack: ExitStack) -> None:
    begun = threading.Event()

    def execute(goal: ServerGoal) -> Any:
        begun.set()
        return until_cancelled(goal) if goal.goal.order == 1 else FibonacciResult(sequence=[goal.goal.order])

    stack.enter_context(SimpleServer(make_node("server"), ACTION, FibonacciAction, execute))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    first = client.send(FibonacciGoal(order=1), timeout=20)
    assert begun.wait(20)
    second = client.send(FibonacciGoal(order=2))
    assert second.result(20).sequence == (2,)
    assert first.wait(20)
    assert first.status is Status.PREEMPTED


def test_goals_that_execute_does_not_end_are_aborted(make_node: Make, stack: ExitStack) -> None:
    def execute(goal: ServerGoal) -> Any:
        match goal.goal.order:
            case 1:
                raise ValueError("no")
            case 2:
                return String("not a result")
            case 3:
                goal.abort(text="ended")
                return FibonacciResult()
        return None

    stack.enter_context(SimpleServer(make_node("server"), ACTION, FibonacciAction, execute))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    for order, text in (1, "ValueError: no"), (2, "not a result"), (3, "ended"), (4, "without finishing"):
        goal = client.send(FibonacciGoal(order=order), timeout=20)
        with pytest.raises(GoalError, match="ABORTED") as caught:
            goal.result(20)
        assert text in caught.value.text


def test_a_goal_is_rejected_and_cannot_change_after_that(make_node: Make, stack: ExitStack) -> None:
    refused: list[ServerGoal] = []

    def on_goal(goal: ServerGoal) -> None:
        refused.append(goal)
        goal.reject(text="too much")

    stack.enter_context(Server(make_node("server"), ACTION, FibonacciAction, on_goal))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    goal = client.send(FibonacciGoal(), timeout=20)
    with pytest.raises(GoalError, match=r"REJECTED \(too much\)"):
        goal.result(20)
    for change in (refused[0].accept, refused[0].succeed, refused[0].cancel, refused[0].abort, refused[0].reject):
        with pytest.raises(ActionError, match="it is REJECTED"):
            change()
    refused[0].ask_to_cancel()
    assert not refused[0].cancel_requested
    with pytest.raises(TypeError, match="feedback must be a"):
        refused[0].feedback(FibonacciGoal())


def test_a_callback_may_wait_for_another_goal(make_node: Make, stack: ExitStack) -> None:
    stack.enter_context(SimpleServer(make_node("server"), ACTION, FibonacciAction, fibonacci))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    got: list[Any] = []
    done = threading.Event()

    def next_goal(_: Any) -> None:
        got.append(client.send(FibonacciGoal(order=3)).result(20))
        done.set()

    client.send(FibonacciGoal(order=2), on_done=next_goal, timeout=20)
    assert done.wait(20)
    assert got[0].sequence == (0, 1, 1, 2)


def test_a_server_that_was_restarted_has_lost_the_goal(make_node: Make, stack: ExitStack) -> None:
    accepted = threading.Event()
    old = Server(make_node("server"), ACTION, FibonacciAction, lambda goal: (goal.accept(), accepted.set()))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    active = threading.Event()
    goal = client.send(FibonacciGoal(), on_stage=lambda _, stage: stage is Stage.ACTIVE and active.set(), timeout=20)
    assert accepted.wait(20)
    assert active.wait(20)
    old.close()
    stack.enter_context(Server(make_node("server2"), ACTION, FibonacciAction, lambda goal: None))
    with pytest.raises(GoalError, match="LOST"):
        goal.result(20)


def test_a_server_that_is_gone_has_lost_the_goal(
    make_node: Make, stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.actions.client.LOST_AFTER", 0.2)
    server = Server(make_node("server"), ACTION, FibonacciAction, lambda goal: goal.accept())
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    goal = client.send(FibonacciGoal(), timeout=20)
    server.close()
    with pytest.raises(GoalError, match="the action server is gone"):
        goal.result(20)


def test_a_lost_goal_is_told_of_though_nobody_waits_for_it(
    make_node: Make, stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.actions.client.LOST_AFTER", 0.2)
    accepted, ended = threading.Event(), threading.Event()
    server = Server(make_node("server"), ACTION, FibonacciAction, lambda goal: (goal.accept(), accepted.set()))
    client = stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))
    goal = client.send(FibonacciGoal(), on_done=lambda _: ended.set(), timeout=20)
    assert accepted.wait(20)
    server.close()
    assert ended.wait(20)
    with pytest.raises(GoalError, match="the action server is gone"):
        goal.outcome()


def test_waits_end_with_the_node_and_the_client(make_node: Make) -> None:
    node = make_node("client")
    client = Client(node, ACTION, FibonacciAction)
    assert not client.wait_for_server(0.01)
    with pytest.raises(WaitTimeoutError, match="no server"):
        client.send(FibonacciGoal(), timeout=0.01)
    with pytest.raises(TypeError, match="FibonacciGoal"):
        client.send(String("x"))
    with SimpleServer(make_node("server"), ACTION, FibonacciAction, until_cancelled):
        goal = client.send(FibonacciGoal(), timeout=20)
        goal.forget()
        assert goal.status is Status.LOST
        other = client.send(FibonacciGoal(), timeout=20)
        client.close()
        assert other.status is Status.LOST
        with pytest.raises(ActionError, match="closed"):
            client.send(FibonacciGoal())
    again = Client(node, ACTION, FibonacciAction)
    node.shutdown()
    with pytest.raises(NodeShutdownError):
        again.wait_for_server(20)


def test_a_goal_that_comes_while_a_server_closes_is_not_carried_out(
    make_node: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The server's thread has found the goal, but not taken it yet, when the server is closed."""
    found, closing, go_on = threading.Event(), threading.Event(), threading.Event()
    executed: list[ServerGoal] = []

    class StoppedCondition(Condition):
        """Stops the thread that has found a goal."""

        def wait_for(self, predicate: Callable[[], object], timeout: float | None = None) -> bool:
            """Wait as usual, and then for `go_on`."""
            holds = super().wait_for(predicate, timeout)
            if holds:
                found.set()
                assert go_on.wait(20)
            return holds

        def notify_all(self) -> None:
            """Wake all waiting threads; note when `close` does so."""
            super().notify_all()
            if threading.current_thread().name == "closer":
                closing.set()

    monkeypatch.setattr("pyros1.actions.simple_server.Condition", StoppedCondition)
    server = SimpleServer(make_node("server"), ACTION, FibonacciAction, executed.append)
    client = Client(make_node("client"), ACTION, FibonacciAction)
    client.send(FibonacciGoal(), timeout=20)
    assert found.wait(20)
    closer = threading.Thread(target=server.close, name="closer")
    closer.start()
    assert closing.wait(20)
    go_on.set()
    closer.join(20)
    assert not closer.is_alive() and executed == []
    client.close()


def test_what_is_no_action(make_node: Make) -> None:
    node = make_node("client")
    for wrong in (String, FibonacciGoal, 3):
        with pytest.raises(ActionError, match="is not an action"):
            Client(node, ACTION, wrong)
    with pytest.raises(TypeError):
        Server(node, ACTION, FibonacciAction, None)  # type: ignore[arg-type]


def test_all_public_names_are_there() -> None:
    for name in actions.__all__:
        assert getattr(actions, name).__name__ == name
    assert set(actions.__all__) <= set(dir(actions))
