"""Links of an action break, with a goal, its result or a request to cancel on their way: all waits end."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from pyros1.actions import Client, ClientGoal, GoalError, Stage, Status
from pyros1.msgs.actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from pyros1.msgs.actionlib_tutorials.msg import (
    FibonacciAction,
    FibonacciActionFeedback,
    FibonacciActionGoal,
    FibonacciActionResult,
    FibonacciGoal,
)
from pyros1.node import Node

Make = Callable[..., Node]
ACTION = "fibonacci"
DEADLINE = 20.0


class Server:
    """A server of the test: it hears goals, and says of them what the test wants. Ends with its node."""

    def __init__(self, node: Node, *statuses: Any) -> None:
        self.cancelled: list[str] = []
        self._statuses = node.advertise(f"{ACTION}/status", GoalStatusArray, latch=True)
        node.advertise(f"{ACTION}/result", FibonacciActionResult)
        node.advertise(f"{ACTION}/feedback", FibonacciActionFeedback)
        node.subscribe(f"{ACTION}/goal", FibonacciActionGoal, lambda message: None)
        node.subscribe(f"{ACTION}/cancel", GoalID, lambda message: self.cancelled.append(message.id))
        self.say(*statuses)

    def say(self, *statuses: Any) -> None:
        """Send the status of all goals."""
        self._statuses.publish(GoalStatusArray(status_list=list(statuses)))


def of(goal: ClientGoal, status: Status) -> Any:
    return GoalStatus(goal_id=GoalID(id=goal.name), status=int(status))


def until(reached: Callable[[], Any], meanwhile: Callable[[], object] = lambda: None) -> None:
    end = time.monotonic() + DEADLINE
    while not reached():
        assert time.monotonic() < end, "not in time"
        meanwhile()
        time.sleep(0.01)


@pytest.fixture
def client(make_node: Make, monkeypatch: pytest.MonkeyPatch) -> Iterator[Client]:
    monkeypatch.setattr("pyros1.actions.progress.LOST_AFTER", 0.05)
    with ExitStack() as stack:
        yield stack.enter_context(Client(make_node("client"), ACTION, FibonacciAction))


@pytest.mark.parametrize("known", [False, True])
def test_a_goal_or_result_that_was_on_its_way_is_lost(make_node: Make, client: Client, known: bool) -> None:
    first = make_node("first")
    server = Server(first)
    goal = client.send(FibonacciGoal(), timeout=DEADLINE)
    if known:  # it has ended, but its result does not come
        until(lambda: goal.stage is Stage.WAITING_FOR_RESULT, lambda: server.say(of(goal, Status.SUCCEEDED)))
    first.shutdown()
    second = Server(make_node("second"))
    until(lambda: goal.done, second.say)
    with pytest.raises(GoalError, match="a connection broke, and the action server does not know the goal"):
        goal.result(DEADLINE)


def test_a_goal_is_not_lost_while_its_link_lives(make_node: Make, client: Client) -> None:
    server = Server(make_node("server"))
    with make_node("ear").subscribe(f"{ACTION}/goal", FibonacciActionGoal, lambda _: None) as ear:
        assert ear.wait_for_publishers(timeout=DEADLINE)
        goal = client.send(FibonacciGoal(), timeout=DEADLINE)
    for _ in range(20):
        server.say()
        time.sleep(0.01)
    assert goal.stage is Stage.WAITING_FOR_GOAL_ACK
    until(lambda: goal.stage is Stage.ACTIVE, lambda: server.say(of(goal, Status.ACTIVE)))


def test_a_request_to_cancel_that_was_lost_is_sent_again(make_node: Make, client: Client) -> None:
    first = make_node("first")
    server = Server(first)
    goal = client.send(FibonacciGoal(), timeout=DEADLINE)
    until(lambda: goal.stage is Stage.ACTIVE, lambda: server.say(of(goal, Status.ACTIVE)))
    first.shutdown()
    until(lambda: not client.is_connected)
    goal.cancel()
    active = of(goal, Status.ACTIVE)
    second = Server(make_node("second"), active)
    until(lambda: second.cancelled, lambda: second.say(active))
    until(lambda: goal.stage is Stage.PREEMPTING, lambda: second.say(of(goal, Status.PREEMPTING)))
    assert set(second.cancelled) == {goal.name}
