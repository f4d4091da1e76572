"""Relays, muxes and demuxes between nodes of the test; interop/tools/test_topic_tools.py compares them with stock's."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from queue import Queue
from typing import Any

import pytest

from pyros1.ground.errors import Error, NodeError, ServiceError
from pyros1.node import Node
from pyros1.topic_tools.demux import Demux
from pyros1.topic_tools.mux import Mux
from pyros1.topic_tools.output import Output, base_name
from pyros1.topic_tools.relay import Relay

from ..parts import publication_of

PATIENCE = 20.0
Start = Callable[[Callable[[], object]], None]


@pytest.fixture
def node(make_node: Callable[..., Node]) -> Node:
    """The tool's node."""
    return make_node("tool")


@pytest.fixture
def user(make_node: Callable[..., Node]) -> Node:
    """The node that publishes and listens."""
    return make_node("user")


@pytest.fixture
def start(node: Node) -> Iterator[Start]:
    """Runs a tool in a thread, until the end of the test."""
    threads: list[threading.Thread] = []

    def begin(run: Callable[[], object]) -> None:
        threads.append(threading.Thread(target=run))
        threads[-1].start()

    yield begin
    node.shutdown()
    for thread in threads:
        thread.join(PATIENCE)


class Ear:
    """A subscriber whose messages can be waited for."""

    def __init__(self, node: Node, topic: str) -> None:
        self._queue: Queue[Any] = Queue()
        self.subscriber = node.subscribe(topic, "std_msgs/String", self._queue.put)
        assert self.subscriber.wait_for_publishers(1, PATIENCE)

    def hears(self, data: str) -> bool:
        """Whether this message is one of those that come."""
        while True:
            message = self._queue.get(timeout=PATIENCE)
            if message.data == data:
                return True


def test_base_names() -> None:
    assert [base_name(name) for name in ("/a/b", "a", "/a/b/")] == ["b", "a", "b"]
    with pytest.raises(Error, match="is not a legal topic name"):
        base_name("//")


def test_a_relay_advertises_what_it_hears(node: Node, user: Node, start: Start, transport: str) -> None:
    output = Output(node, "/out")
    start(Relay(node, "/in", output).run)
    publisher: Any = user.advertise("/in", "std_msgs/String", latch=True)
    publisher.publish("first")
    ear = Ear(user, "/out")
    assert ear.hears("first")
    publisher.publish("second")
    assert ear.hears("second")
    assert output.header is not None
    assert output.header["type"] == "std_msgs/String"


def test_a_topic_is_not_forwarded_to_itself(node: Node) -> None:
    with pytest.raises(NodeError, match="to itself"):
        Relay(node, "/same", Output(node, "same"))


def test_another_type_is_dropped(node: Node, user: Node, make_node: Callable[..., Node], start: Start) -> None:
    output = Output(node, "/out", latch=True)
    start(Relay(node, "/in", output).run)
    texts: Any = user.advertise("/in", "std_msgs/String", latch=True)
    texts.publish("text")
    ear = Ear(user, "/out")
    assert ear.hears("text")
    other = make_node("other")
    numbers: Any = other.advertise("/in", "std_msgs/Int64")
    assert numbers.wait_for_subscribers(1, PATIENCE)
    numbers.publish(5)
    texts.publish("more")
    assert ear.hears("more")


def test_a_lazy_relay_leaves_and_comes_back(node: Node, user: Node, start: Start) -> None:
    start(Relay(node, "/in", Output(node, "/out")).run_lazy)
    publisher: Any = user.advertise("/in", "std_msgs/String")
    assert publisher.wait_for_subscribers(1, PATIENCE)
    left = threading.Event()
    publication_of(user, "/in").change_listeners.append(lambda: publisher.num_connections or left.set())
    publisher.publish("unheard")
    assert left.wait(PATIENCE)
    ear = Ear(user, "/out")
    assert publisher.wait_for_subscribers(1, PATIENCE)
    publisher.publish("heard")
    assert ear.hears("heard")


def test_a_mux_is_switched(node: Node, user: Node, start: Start) -> None:
    mux = Mux(node, "/out", ["/left", "/right"], latch=True)
    start(mux.run)
    left: Any = user.advertise("/left", "std_msgs/String")
    right: Any = user.advertise("/right", "std_msgs/String")
    for publisher in (left, right):
        assert publisher.wait_for_subscribers(1, PATIENCE)
    left.publish("one")
    ear = Ear(user, "/out")
    assert ear.hears("one")
    select = user.service("/mux/select", "topic_tools/MuxSelect")
    assert select("right").prev_topic == "/left"
    right.publish("two")
    assert ear.hears("two")
    assert select("__none").prev_topic == "/right"
    assert select("/left").prev_topic == ""
    with pytest.raises(ServiceError, match="cannot select /nowhere: unknown topic"):
        select("/nowhere")
    with pytest.raises(ServiceError, match="not a legal ROS name"):
        select("no name")
    listed = user.service("/mux/list", "topic_tools/MuxList")
    assert listed().topics == ["/left", "/right"]
    with pytest.raises(ServiceError, match="is selected"):
        user.service("/mux/delete", "topic_tools/MuxDelete")("/left")


def test_a_demux_is_switched(node: Node, user: Node, start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.topic_tools.demux.CONNECT_DELAY", 0.0)
    start(Demux(node, "/in", ["/left", "/right"]).run)
    publisher: Any = user.advertise("/in", "std_msgs/String")
    assert publisher.wait_for_subscribers(1, PATIENCE)
    publisher.publish("nobody is there")
    left, right = Ear(user, "/left"), Ear(user, "/right")
    publisher.publish("one")
    assert left.hears("one")
    select = user.service("/demux/select", "topic_tools/DemuxSelect")
    assert select("/right").prev_topic == "/left"
    publisher.publish("two")
    assert right.hears("two")
    select("__none")
    publisher.publish("lost")
    select("/left")
    publisher.publish("three")
    assert left.hears("three")
