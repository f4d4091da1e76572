"""Who is connected to whom, and how much flows."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import closing
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.graph import Graph
from pyros1.master.server import Master
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.net.master_client import MasterClient
from pyros1.web.system import Flow, System, parse_flows

PATIENCE = 20.0
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=30,
)


@pytest.mark.parametrize(
    ("stats", "found"),
    [
        ([[["/a", 60, [[3, 60, 5, True], [4, 12, 1, True]]]], [], []], [Flow("/a", 3, 5, 40), Flow("/a", 4, 1, 8)]),
        ([[["/a", 0, []]], []], []),
        ([[["/a", 3e9, [[0, 3e10, 4e9, True], [1, float("inf"), 1]]]], []], [Flow("/a", 0, 4 * 10**9, 14 * 10**9)]),
        ([[["/a", 0, [[3, "60", 5]]], ["/b", 0, [["x", 1, 2]]]], []], [Flow("/b", "x", 2, 0)]),
        (None, []),
        ("text", []),
        ([], []),
        ([7], []),
    ],
)
def test_what_nodes_count(stats: Any, found: list[Flow]) -> None:
    assert parse_flows(stats) == found


@given(JSON)
def test_any_answer_is_read(stats: Any) -> None:
    for flow in parse_flows(stats):
        assert isinstance(flow.messages, int)


@pytest.mark.parametrize("transport", ["tcp"], indirect=True)
def test_rates_and_edges(environ: dict[str, str], make_node: Callable[..., Any], transport: str) -> None:
    now = 100.0
    client = MasterClient("/test", environ["ROS_MASTER_URI"])
    system = System(Graph(client), lambda: now)
    talker, listener = make_node("talker"), make_node("listener")
    publisher = talker.advertise("topic1", Float64, queue_size=0)
    received: list[float] = []
    listener.subscribe("topic1", Float64, lambda message: received.append(message.data))
    listener.advertise_service("reset", "std_srvs/Empty", lambda request: None)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(0.0)
    first = system.describe(0.0)
    assert {*first["nodes"]} == {"/talker", "/listener"}
    topic = first["topics"]["/topic1"]
    assert (topic["type"], topic["publishers"], topic["subscribers"]) == (
        "std_msgs/Float64",
        ["/talker"],
        ["/listener"],
    )
    assert ["/topic1", "/talker", "/listener", None] in first["edges"]
    assert first["services"]["/reset"] == ["/listener"]
    assert (first["silent"], first["missing"]) == ([], [])
    before = publisher.links[0].messages
    for number in range(50):
        publisher.publish(float(number))
    sent = publisher.links[0].messages - before
    now += 2.0
    again = system.describe(1.0)
    assert again["topics"]["/topic1"]["hz"] == sent / 2.0
    assert ["/topic1", "/talker", "/listener", sent / 2.0] in again["edges"]
    assert system.describe(1.0) is again  # young enough
    client.close()


def test_a_node_that_does_not_answer_is_silent(environ: dict[str, str]) -> None:
    client = MasterClient("/ghost", environ["ROS_MASTER_URI"])
    client.call("registerPublisher", "/topic1", "std_msgs/Float64", "http://127.0.0.1:1/")
    description = System(Graph(client)).describe(0.0)
    assert description["silent"] == ["/ghost"]
    assert description["topics"]["/topic1"]["publishers"] == ["/ghost"]
    client.close()


def test_a_connection_that_should_be_there(environ: dict[str, str], make_node: Callable[..., Any]) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    client = MasterClient("/other", environ["ROS_MASTER_URI"])
    # as if each had registered, but the listener could not reach the talker
    for name, method, node in [("/talker", "registerPublisher", talker), ("/listener", "registerSubscriber", listener)]:
        with closing(MasterClient(name, environ["ROS_MASTER_URI"])) as master:
            master.call(method, "/topic2", "std_msgs/Float64", node.uri)
    system = System(Graph(client))
    assert system.describe(0.0)["missing"] == []  # it may be on its way
    assert system.describe(0.0)["missing"] == [["/topic2", "/talker", "/listener"]]
    client.close()


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def system(master: Master, clock: Clock) -> Any:
    client = MasterClient("/test", master.uri)
    yield System(Graph(client), clock)
    client.close()


def look(system: System, clock: Clock) -> dict[str, Any]:
    clock.now += 1.0
    return system.describe(max_age=0.5)


def looks_until(system: System, clock: Clock, fits: Callable[[dict[str, Any]], Any]) -> dict[str, Any]:
    until = time.monotonic() + PATIENCE
    while not fits(found := look(system, clock)):
        assert time.monotonic() < until, found
    return found


def test_each_subscriber_has_its_rate(system: System, clock: Clock, make_node: Callable[..., Any]) -> None:
    """The nodes number connections per topic in one table and per node in the other."""
    talker = make_node("talker", rosout=False)
    heard = [threading.Semaphore(0) for _ in range(3)]
    for index, semaphore in enumerate(heard):
        node = make_node(f"listener{index}", rosout=False)
        node.subscribe("first" if index == 0 else "second", Float64, lambda message, it=semaphore: it.release())
    first, second = talker.advertise("first", Float64), talker.advertise("second", Float64)
    for publisher, count in ((first, 1), (second, 2)):
        assert publisher.wait_for_subscribers(count, timeout=PATIENCE)
    looks_until(system, clock, lambda found: len(found["edges"]) == 3)
    for publisher, count in ((first, 2), (second, 4)):
        for _ in range(count):
            publisher.publish(Float64(1.0))
    for semaphore, count in zip(heard, (2, 4, 4), strict=True):
        for _ in range(count):
            assert semaphore.acquire(timeout=PATIENCE)
    found = look(system, clock)
    assert [edge[2:] for edge in found["edges"]] == [["/listener0", 2.0], ["/listener1", 4.0], ["/listener2", 4.0]]
    assert found["topics"]["/second"]["hz"] == 4.0


def test_a_slow_topic_has_one_rate(system: System, clock: Clock, make_node: Callable[..., Any]) -> None:
    """It was 0 Hz and twice its rate by turns."""
    heard = threading.Semaphore(0)
    make_node("listener", rosout=False).subscribe("slow", Float64, lambda message: heard.release())
    publisher = make_node("talker", rosout=False).advertise("slow", Float64)
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    assert looks_until(system, clock, lambda found: found["edges"])["topics"]["/slow"]["hz"] is None
    rates = []
    for number in range(20):
        if number % 2 == 0:
            publisher.publish(Float64(1.0))
            assert heard.acquire(timeout=PATIENCE)
        found = look(system, clock)
        rates.append((found["topics"]["/slow"]["hz"], found["edges"][0][3]))
    assert rates == [(None, None)] * 2 + [(0.5, 0.5)] * 18


def test_an_edge_is_missing_when_it_was_missing_before(
    system: System, clock: Clock, make_node: Callable[..., Any]
) -> None:
    talker, listener = make_node("talker", rosout=False), make_node("listener", rosout=False, log_level="fatal")
    talker.advertise("chat", String)
    listener.subscribe("chat", Float64, lambda message: None)
    registered = looks_until(system, clock, lambda found: found["topics"].get("/chat", {}).get("subscribers"))
    assert registered["missing"] == []
    assert look(system, clock)["missing"] == [["/chat", "/talker", "/listener"]]


def test_silent_nodes_miss_nothing(system: System, clock: Clock, master: Master, closed_port: int) -> None:
    client = MasterClient("/gone", master.uri)
    client.register_publisher("/t", "std_msgs/String", f"http://localhost:{closed_port}/")
    client.register_subscriber("/t", "std_msgs/String", f"http://localhost:{closed_port}/")
    client.close()
    look(system, clock)
    found = look(system, clock)
    assert (found["silent"], found["missing"]) == (["/gone"], [])
