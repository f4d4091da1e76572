"""Who is connected to whom, and how much flows."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.graph import Graph
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.net.master_client import MasterClient
from pyros1.web.system import Flow, System, flows

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=30,
)


@pytest.mark.parametrize(
    ("stats", "found"),
    [
        ([[["/a", 60, [[3, 60, 5, True], [4, 12, 1, True]]]], [], []], [Flow("/a", 3, 5, 60), Flow("/a", 4, 1, 12)]),
        ([[["/a", 0, []]], []], []),
        ([[["/a", 0, [[3, "60", 5]]], ["/b", 0, [["x", 1, 2]]]], []], [Flow("/b", "x", 2, 1)]),
        (None, []),
        ("text", []),
        ([], []),
        ([7], []),
    ],
)
def test_what_nodes_count(stats: Any, found: list[Flow]) -> None:
    assert flows(stats) == found


@given(JSON)
def test_any_answer_is_read(stats: Any) -> None:
    for flow in flows(stats):
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
    description = System(Graph(client)).describe(0.0)
    assert description["missing"] == [["/topic2", "/talker", "/listener"]]
    client.close()
