"""Lookups in another node's buffer, and the protocol that they go by (L199)."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import load_message
from pyros1.node import Node
from pyros1.tf import Buffer, BufferClient, BufferServer, TimeoutException, TransformException

Make = Callable[..., Node]
PATIENCE = 20.0
STATUS: Any = load_message("actionlib_msgs/GoalStatus")


def stamped(parent: str, child: str, seconds: float, x: float = 0.0) -> Any:
    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id, message.child_frame_id = parent, child
    message.header.stamp = Time.from_sec(seconds)
    message.transform.translation.x = x
    message.transform.rotation.w = 1.0
    return message


@pytest.fixture
def buffer(make_node: Make) -> Buffer:
    """A buffer that is served: map -> base is static, map -> moving known from 5 s to 6 s."""
    buffer = Buffer()
    buffer.set_transform_static(stamped("map", "base", 0, 1.5))
    buffer.set_transform_static(stamped("other", "island", 0))
    for seconds in (5.0, 6.0):
        buffer.set_transform(stamped("map", "moving", seconds, seconds))
    BufferServer(make_node("server", rosout=False), buffer)
    return buffer


class Actor:
    """Speaks the protocol by hand.

    Attributes:
        results: outcomes as they come.
        statuses: lists of ``(id, status)`` as they come.
    """

    def __init__(self, node: Node) -> None:
        self.results: queue.Queue[Any] = queue.Queue()
        self.statuses: queue.Queue[list[tuple[str, int]]] = queue.Queue()
        self.goals: Any = node.advertise("tf2_buffer_server/goal", "tf2_msgs/LookupTransformActionGoal")
        self.cancels: Any = node.advertise("tf2_buffer_server/cancel", "actionlib_msgs/GoalID")
        result = node.subscribe("tf2_buffer_server/result", "tf2_msgs/LookupTransformActionResult", self.results.put)
        node.subscribe("tf2_buffer_server/status", "actionlib_msgs/GoalStatusArray", self._statuses_came)
        assert self.goals.wait_for_subscribers(timeout=PATIENCE)
        assert self.cancels.wait_for_subscribers(timeout=PATIENCE)
        assert result.wait_for_publishers(timeout=PATIENCE)

    def _statuses_came(self, message: Any) -> None:
        self.statuses.put([(each.goal_id.id, each.status) for each in message.status_list])

    def send(self, name: str, source: str, timeout: float = 0.0, stamp: float = 0.0) -> None:
        goal = load_message("tf2_msgs/LookupTransformActionGoal")()
        goal.goal_id.id, goal.goal_id.stamp = name, Time.from_sec(stamp)
        goal.goal.target_frame, goal.goal.source_frame = "map", source
        goal.goal.timeout = Duration.from_sec(timeout)
        self.goals.publish(goal)

    def await_status(self, *expected: tuple[str, int]) -> None:
        while self.statuses.get(timeout=PATIENCE) != list(expected):
            pass

    def outcome(self) -> tuple[str, int, int]:
        """The next goal that ends: its id, its status, the code of the error."""
        message = self.results.get(timeout=PATIENCE)
        return message.status.goal_id.id, message.status.status, message.result.error.error


@pytest.fixture
def actor(make_node: Make, buffer: Buffer) -> Actor:
    return Actor(make_node("actor", rosout=False))


# Lookups --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_lookups(make_node: Make, buffer: Buffer, transport: str, callbacks: str) -> None:
    """In a node that spins, too, a lookup in the main thread gets its answer."""
    client = BufferClient(make_node("client", callbacks=callbacks))
    found = client.lookup_transform("map", "base")
    assert (found.header.frame_id, found.child_frame_id, found.transform.translation.x) == ("map", "base", 1.5)
    assert client.lookup_transform("map", "moving", 5.5).transform.translation.x == pytest.approx(5.5)
    assert client.lookup_transform("map", "moving", Time(5)).header.stamp == Time(5)
    full = client.lookup_transform_full("moving", 6.0, "moving", 5.0, "map", timeout=Duration(1))
    assert full.transform.translation.x == pytest.approx(-1.0)
    assert client.can_transform("map", "base")
    assert not client.can_transform("map", "none")
    assert client.can_transform_full("moving", 6.0, "moving", 5.0, "map")
    assert not client.can_transform_full("moving", 6.0, "moving", 5.0, "none")
    client.close()


@pytest.mark.parametrize(
    "question",
    [("map", "none"), ("map", "island"), ("map", "moving", 99.0), ("map", ""), ("/map", "base"), ("map", "moving", 1)],
)
def test_failures_are_those_of_the_buffer(make_node: Make, buffer: Buffer, question: tuple[Any, ...]) -> None:
    with pytest.raises(TransformException) as expected:
        buffer.lookup_transform(*question)
    with pytest.raises(TransformException) as error:
        BufferClient(make_node("client")).lookup_transform(*question, timeout=0.05 if question[1] == "none" else 0)
    assert (type(error.value), str(error.value)) == (type(expected.value), str(expected.value))


def test_a_transform_that_comes_later(make_node: Make, buffer: Buffer, actor: Actor) -> None:
    client = BufferClient(make_node("client"))
    found: list[float] = []

    def look() -> None:
        found.append(client.lookup_transform("map", "late", timeout=60).transform.translation.x)

    thread = threading.Thread(target=look)
    thread.start()
    while [status for _, status in actor.statuses.get(timeout=PATIENCE)] != [STATUS.ACTIVE]:
        pass
    buffer.set_transform(stamped("map", "late", 5, 7.0))
    thread.join(PATIENCE)
    assert found == [7.0]


def test_no_server(make_node: Make) -> None:
    client = BufferClient(make_node("client"), timeout_padding=0.05)
    assert not client.wait_for_server(0.05)
    with pytest.raises(TimeoutException, match="no buffer server at /tf2_buffer_server"):
        client.lookup_transform("map", "base")


def test_a_server_that_does_not_answer_is_told_to_give_up(make_node: Make) -> None:
    mute = make_node("mute")
    cancels: queue.Queue[Any] = queue.Queue()
    mute.subscribe("/other/goal", "tf2_msgs/LookupTransformActionGoal", lambda _: None)
    cancelled = mute.subscribe("/other/cancel", "actionlib_msgs/GoalID", cancels.put)
    mute.advertise("/other/result", "tf2_msgs/LookupTransformActionResult")
    client = BufferClient(make_node("client"), "/other", timeout_padding=Duration(0, 50_000_000))
    assert client.wait_for_server()
    assert cancelled.wait_for_publishers(timeout=PATIENCE)
    with pytest.raises(TimeoutException, match="did not respond"):
        client.lookup_transform("map", "base")
    assert cancels.get(timeout=PATIENCE).id.startswith("/client-1-")


@pytest.mark.parametrize("lost", [STATUS.PREEMPTED, STATUS.SUCCEEDED, STATUS.ABORTED, STATUS.REJECTED, STATUS.RECALLED])
def test_an_answer_that_was_lost_is_asked_for_again(make_node: Make, lost: int) -> None:
    """A server may see the one who listens to results after it has answered."""
    server = make_node("server")
    results: Any = server.advertise("/other/result", "tf2_msgs/LookupTransformActionResult")
    statuses: Any = server.advertise("/other/status", "actionlib_msgs/GoalStatusArray")
    client = BufferClient(make_node("client"), "/other", timeout_padding=PATIENCE)
    asked: list[str] = []

    def answer(goal: Any) -> None:
        asked.append(goal.goal_id.id)
        if len(asked) > 1:
            outcome: Any = results.type(status=STATUS(goal.goal_id, STATUS.SUCCEEDED, ""))
            outcome.result.transform.child_frame_id = "base"
            results.publish(outcome)
        else:
            for _ in range(2):
                statuses.publish(status_list=[STATUS(goal.goal_id, lost, "")])

    server.subscribe("/other/goal", "tf2_msgs/LookupTransformActionGoal", answer)
    assert statuses.wait_for_subscribers(timeout=PATIENCE)
    assert results.wait_for_subscribers(timeout=PATIENCE)
    assert client.lookup_transform("map", "base").child_frame_id == "base"
    assert len(set(asked)) == 2


def test_the_node_ends_during_a_lookup(make_node: Make, actor: Actor) -> None:
    node = make_node("client")
    client = BufferClient(node)
    ends: list[Exception] = []

    def look() -> None:
        try:
            client.lookup_transform("map", "none", timeout=60)
        except NodeShutdownError as error:
            ends.append(error)

    thread = threading.Thread(target=look)
    thread.start()
    while not actor.statuses.get(timeout=PATIENCE):
        pass
    node.shutdown()
    thread.join(PATIENCE)
    assert len(ends) == 1


# The protocol ---------------------------------------------------------------------------------------------------------


def test_a_goal_is_accepted_and_answered_once(actor: Actor, buffer: Buffer) -> None:
    actor.send("a", "late", timeout=60)
    actor.await_status(("a", STATUS.ACTIVE))
    actor.send("a", "base")
    actor.send("b", "base")
    assert actor.outcome() == ("b", STATUS.SUCCEEDED, 0)
    actor.await_status(("a", STATUS.ACTIVE), ("b", STATUS.SUCCEEDED))
    buffer.set_transform_static(stamped("map", "late", 0))
    assert actor.outcome() == ("a", STATUS.SUCCEEDED, 0)


def test_a_goal_without_a_name_gets_one(actor: Actor) -> None:
    actor.send("", "none")
    name, status, code = actor.outcome()
    assert (name.startswith("/server-1-"), status, code) == (True, STATUS.SUCCEEDED, 1)


def test_cancelled_goals(actor: Actor) -> None:
    goal_id: Any = load_message("actionlib_msgs/GoalID")
    for number, name in enumerate("abcd", 1):
        actor.send(name, "none", timeout=60, stamp=number)
    actor.await_status(*((name, STATUS.ACTIVE) for name in "abcd"))
    actor.cancels.publish(goal_id(Time(), "b"))
    assert actor.outcome() == ("b", STATUS.PREEMPTED, 0)
    actor.cancels.publish(goal_id(Time(3), ""))
    assert [actor.outcome()[:2] for _ in "ac"] == [("a", STATUS.PREEMPTED), ("c", STATUS.PREEMPTED)]
    actor.send("e", "none", timeout=60, stamp=2)
    assert actor.outcome() == ("e", STATUS.RECALLED, 0)
    actor.cancels.publish(goal_id())
    assert actor.outcome() == ("d", STATUS.PREEMPTED, 0)


def test_a_cancel_that_overtakes_its_goal(actor: Actor) -> None:
    actor.cancels.publish(load_message("actionlib_msgs/GoalID")(Time(), "a"))
    actor.await_status(("a", STATUS.RECALLING))
    actor.send("a", "base")
    assert actor.outcome() == ("a", STATUS.RECALLED, 0)


def test_a_lookup_that_another_cancels(make_node: Make, actor: Actor) -> None:
    client = BufferClient(make_node("client"))
    ends: list[str] = []

    def look() -> None:
        try:
            client.lookup_transform("map", "none", timeout=60)
        except TransformException as error:
            ends.append(str(error))

    thread = threading.Thread(target=look)
    thread.start()
    while not actor.statuses.get(timeout=PATIENCE):
        pass
    actor.cancels.publish(load_message("actionlib_msgs/GoalID")())
    thread.join(PATIENCE)
    assert ends == ["the server has cancelled the lookup (status 2)"]


def test_goals_that_ended_are_forgotten(actor: Actor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.tf.buffer_server.STATUS_RETENTION", Duration(0, 100_000_000))
    actor.send("a", "base")
    actor.await_status(("a", STATUS.SUCCEEDED))
    actor.await_status()


def test_a_server_that_is_closed(make_node: Make) -> None:
    node = make_node("server")
    server = BufferServer(node, Buffer(), "mine")
    client = BufferClient(make_node("client"), "mine", timeout_padding=0.05)
    assert client.wait_for_server(PATIENCE)
    server.close()
    with pytest.raises(TimeoutException):
        client.lookup_transform("map", "base")


@pytest.mark.parametrize("checks_before", [True, False])
def test_a_lookup_is_answered_when_simulated_time_begins_again(
    make_node: Make, monkeypatch: pytest.MonkeyPatch, checks_before: bool
) -> None:
    may_check = threading.Event()
    if checks_before:
        may_check.set()
    world = make_node("world", rosout=False)
    world.params["/use_sim_time"] = True
    clock: Any = world.advertise("/clock", "rosgraph_msgs/Clock")
    node = make_node("server", rosout=False)
    timer = node.timer
    monkeypatch.setattr(
        node, "timer", lambda time, check: timer(time, lambda event: may_check.is_set() and check(event))
    )
    BufferServer(node, Buffer())
    actor = Actor(world)
    assert clock.wait_for_subscribers(timeout=PATIENCE)
    ticks = iter(range(10**6))

    def play_until(reached: Callable[[], bool], begin: float) -> None:
        for _ in range(1000):
            clock.publish(Time.from_sec(begin + next(ticks) * 0.1))
            if reached():
                return
            threading.Event().wait(0.005)
        raise AssertionError("not in time")

    play_until(lambda: node.now() >= Time(1000), 1000.0)
    actor.send("late", "nowhere", timeout=100_000.0)
    play_until(lambda: not actor.statuses.empty() and actor.statuses.get() == [("late", STATUS.ACTIVE)], 1000.0)
    play_until(lambda: node.now() < Time(1000), 0.0)
    may_check.set()
    play_until(lambda: not actor.results.empty(), 0.0)
    assert actor.results.get().result.error.error != 0
