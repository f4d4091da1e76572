"""What the nodes count and report, put together."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.graph import Graph
from pyros1.master.server import Master
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.net.master_client import MasterClient
from pyros1.web.system import System, flows

PATIENCE = 20.0


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


def test_an_edge_is_missing_when_it_was_missing_before(
    system: System, clock: Clock, make_node: Callable[..., Any]
) -> None:
    talker, listener = make_node("talker", rosout=False), make_node("listener", rosout=False, log_level="fatal")
    talker.advertise("chat", String)
    listener.subscribe("chat", Float64, lambda message: None)
    registered = looks_until(system, clock, lambda found: found["topics"].get("/chat", {}).get("subscribers"))
    assert registered["missing"] == []
    assert look(system, clock)["missing"] == [["/chat", "/talker", "/listener"]]


def test_silent_nodes_miss_nothing(system: System, clock: Clock, master: Master, free_port: int) -> None:
    client = MasterClient("/gone", master.uri)
    client.register_publisher("/t", "std_msgs/String", f"http://localhost:{free_port}/")
    client.register_subscriber("/t", "std_msgs/String", f"http://localhost:{free_port}/")
    client.close()
    look(system, clock)
    found = look(system, clock)
    assert (found["silent"], found["missing"]) == (["/gone"], [])


@pytest.mark.parametrize(
    "stats", [None, [], "x", [None], [[["/t"]]], [[["/t", 0, [["a"], [1, "x", 2]]]]], [[[5, 0, []]]]]
)
def test_odd_counts_are_left_out(stats: object) -> None:
    assert flows(stats) == []
