"""A ROS 2 node as a server of dynamic_reconfigure: what changes while it is asked, and when it is asked again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pytest

from pyros1.graph import Graph
from pyros1.ground.errors import ServiceRefusal
from pyros1.msgs.dynamic_reconfigure.msg import Config, IntParameter
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure
from pyros1.node import Node
from pyros1.reconfigure.encoding import decode
from pyros1.ros2.bridge.parameters import reconfigured
from pyros1.ros2.bridge.parameters.messages import Descriptor, Event, Value
from pyros1.ros2.bridge.parameters.nodes import ParameterNode
from pyros1.ros2.bridge.parameters.parameter_client import ParameterClient
from pyros1.ros2.bridge.parameters.reconfigured import ReconfiguredNode

from .fake_node import EVENTS


class FakeAsking(ParameterClient):
    """Answers by itself; `then` is done before it returns values that it has read."""

    def __init__(self) -> None:
        super().__init__(lambda key, body, timeout: b"")
        self.known: dict[str, Value] = {"rate": 5, "frame": "map"}
        self.then: Callable[[], object] = lambda: None
        self.problem = ""

    def names(self, node: ParameterNode) -> list[str]:
        if self.problem:
            raise ServiceRefusal(self.problem)
        return [*self.known]

    def descriptors(self, node: ParameterNode, names: Sequence[str]) -> list[Descriptor]:
        return [Descriptor(name, "", False) for name in names]

    def values(self, node: ParameterNode, names: Sequence[str]) -> dict[str, Value]:
        read = {name: self.known[name] for name in names}
        self.then()
        return read

    def set(self, node: ParameterNode, values: Mapping[str, bool | int | float | str]) -> dict[str, str]:
        self.known |= values
        return {}


class Clock:
    """Seconds that pass only when a test lets them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(reconfigured, "monotonic", lambda: self.now)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


@pytest.fixture
def parameter_client() -> FakeAsking:
    return FakeAsking()


@pytest.fixture
def server(make_node: Callable[..., Node], parameter_client: FakeAsking, clock: Clock) -> ReconfiguredNode:
    node = make_node("bridge")
    return ReconfiguredNode(node, Graph(node.master), ParameterNode("/camera", (), EVENTS), parameter_client)


def change(server: ReconfiguredNode, **values: Value) -> None:
    server.on_event(Event("/camera", dict(values), False))


def request(node: Node, **ints: int) -> dict[str, Any]:
    config = Config(ints=[IntParameter(name, value) for name, value in ints.items()])
    with node.service("/camera/set_parameters", Reconfigure) as client:
        values: dict[str, Any] = decode(client(config).config, dict)
    return values


def test_a_change_while_all_are_asked(
    server: ReconfiguredNode, parameter_client: FakeAsking, make_node: Callable[..., Node]
) -> None:
    assert server.begin() and not server.begin()
    parameter_client.then = lambda: change(server, rate=8)
    server.ask()
    server.adjust()
    parameter_client.then = lambda: None
    assert request(make_node("user")) == {"rate": 8, "frame": "map"}
    assert not server.begin(), "it need not be asked again"


def test_a_change_by_others_while_one_is_set(
    server: ReconfiguredNode, parameter_client: FakeAsking, make_node: Callable[..., Node]
) -> None:
    assert server.begin()
    server.ask()
    server.adjust()
    parameter_client.then = lambda: change(server, rate=9)
    user = make_node("user")
    assert request(user, rate=7)["rate"] == 9, "that came later"
    parameter_client.then = lambda: change(server, frame="odom")
    assert request(user, rate=3) == {"rate": 3, "frame": "odom"}


def test_a_node_that_fails_is_asked_ever_more_rarely(
    server: ReconfiguredNode, parameter_client: FakeAsking, clock: Clock
) -> None:
    parameter_client.problem = "node /camera of ROS 2 is asleep"
    pauses = []
    for _ in range(9):
        start = clock.now
        while not server.begin():
            clock.now += 1.0
        pauses.append(clock.now - start)
        server.ask()
        assert server.problem == parameter_client.problem
    assert pauses == [0.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 300.0, 300.0]
    parameter_client.problem, clock.now = "", clock.now + 300.0
    assert server.begin()
    server.ask()
    assert not server.problem


def test_how_often_a_node_is_asked_that_has_other_parameters_again_and_again(
    server: ReconfiguredNode, clock: Clock
) -> None:
    times = []
    assert server.begin()
    server.ask()
    for _ in range(100):
        server.on_event(Event("/camera", {}, True))
        clock.now += 0.125
        if server.begin():
            times.append(clock.now - 100.0)
            server.ask()
    assert 4 <= len(times) <= 6, times
    clock.now += 10.0
    server.begin()
    server.ask()
    clock.now += 10.0
    server.on_event(Event("/camera", {}, True))
    assert not server.begin(), "others may come soon"
    clock.now += 0.5
    assert server.begin()


def test_a_name_that_ros1_does_not_allow(make_node: Callable[..., Node], parameter_client: FakeAsking) -> None:
    node = make_node("bridge")
    server = ReconfiguredNode(node, Graph(node.master), ParameterNode("/a-b", (), EVENTS), parameter_client)
    assert not server.begin() and server.problem == "ROS 1 does not allow its name"
    server.on_event(Event("/a-b", {}, True))
    server.adjust()
    assert not server.begin()
