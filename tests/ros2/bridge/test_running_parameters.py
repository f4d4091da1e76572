"""Parameters of ROS 2 nodes at a running bridge: as those of a server of dynamic_reconfigure, and read by a command.

Feature: parameters of ROS 2 nodes in dynamic_reconfigure's tools -- `pyros1 bridge ros2 --reconfigure`
Feature: parameters of ROS 2 nodes, read by a command -- `pyros1 bridge param ros2:`
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh")

from pyros1.bridge.parameters import (
    PARAMETER_SERVICE,
    ParameterRequest,
    decode_parameter_response,
    encode_parameter_request,
)
from pyros1.bridge.service_ends import PARAMETERS_CLASS
from pyros1.ground.errors import ServiceError
from pyros1.msgs import AnyMsg
from pyros1.reconfigure.client import Client
from pyros1.ros2.bridge.parameters import exchange, reconfigured
from pyros1.ros2.bridge.rules import Ros2Rules

from ...bridge.conftest import PATIENCE, wait_until
from .parameters.fake_node import EVENTS, HASHES, FakeNode
from .test_running import Ros2Peer, RunningBridge, endpoint

__all__ = ["endpoint"]

VALUES = {
    "use_sim_time": False,
    "rate": 5,
    "gains.p": 1.5,
    "frame": "map",
    "limits": [1.0, 2.0],
    "serial": "X1",
    "big": 1 << 40,
    "unset": None,
    "qos_overrides./tf.publisher.depth": 7,
    "groups": 1,
}
SAID = {
    "rate": {"text": "frames per second.", "constraints": "odd", "integers": (1, 9)},
    "gains.p": {"doubles": (0.0, 10.0)},
    "serial": {"read_only": True},
    "qos_overrides./tf.publisher.depth": {"read_only": True},
}


@pytest.fixture
def bridge(endpoint: str, tmp_path: Path) -> Iterator[RunningBridge]:
    running = RunningBridge(tmp_path, Ros2Rules(["/**"], ["/**"], ["/camera", "/bad*"]), listen=[endpoint])
    yield running
    running.close()


@pytest.fixture
def make_ros2(bridge: RunningBridge, endpoint: str) -> Iterator[Callable[..., FakeNode]]:
    nodes: list[FakeNode] = []

    def make(name: str = "/camera", *args: Any, **settings: Any) -> FakeNode:
        nodes.append(FakeNode(Ros2Peer(endpoint), name, *(args or (VALUES, SAID)), **settings))
        return nodes[-1]

    yield make
    for node in nodes:
        node.close()
        node.peer.session.close()


@pytest.fixture
def camera(make_ros2: Callable[..., FakeNode]) -> FakeNode:
    return make_ros2()


class Tool:
    """A client of dynamic_reconfigure in ROS 1."""

    def __init__(self, bridge: RunningBridge, name: str = "/camera") -> None:
        self.seen: list[dict[str, Any]] = []
        self._client = Client(bridge.make_node("tool"), name, PATIENCE, on_config=self._note)

    def _note(self, config: Any) -> None:
        self.seen.append(without_groups(config))

    def description(self) -> dict[str, Any]:
        return {each["name"]: each for each in self._client.description(PATIENCE)}

    def config(self) -> dict[str, Any]:
        return without_groups(self._client.config(PATIENCE))

    def set(self, **changes: Any) -> dict[str, Any]:
        return without_groups(self._client.update(changes, PATIENCE))

    def sees(self, **values: Any) -> None:
        wait_until(lambda: self.seen and values.items() <= self.seen[-1].items(), f"a tool sees {values}")


def without_groups(config: Any) -> dict[str, Any]:
    return {name: value for name, value in config.items() if name != "groups"}


def test_a_node_of_ros2_is_a_server_of_dynamic_reconfigure(bridge: RunningBridge, camera: FakeNode) -> None:
    tool = Tool(bridge)
    assert tool.config() == {"use_sim_time": False, "rate": 5, "gains.p": 1.5, "frame": "map"}
    described = tool.description()
    assert described.keys() == tool.config().keys()
    rate = described["rate"]
    assert (rate["type"], rate["min"], rate["max"], rate["description"]) == ("int", 1, 9, "frames per second. odd")
    assert (described["gains.p"]["min"], described["gains.p"]["max"]) == (0.0, 10.0)
    assert (described["use_sim_time"]["type"], described["frame"]["type"]) == ("bool", "str")
    assert camera.asked == ["list_parameters", "describe_parameters", "get_parameters"], "nothing is asked twice"
    assert "/camera/set_parameters" in bridge.services()
    camera.peer.session.close()
    wait_until(lambda: "/camera/set_parameters" not in bridge.services(), "it is gone with the node")
    wait_until(lambda: not any(name.startswith("/camera") for name in bridge.topics()), "its topics, too")


def test_setting_parameters(bridge: RunningBridge, camera: FakeNode) -> None:
    tool = Tool(bridge)
    assert tool.set(rate=7, frame="odom") == {**tool.config(), "rate": 7, "frame": "odom"}
    assert (camera.values["rate"], camera.values["frame"]) == (7, "odom")
    assert tool.set(**{"gains.p": 99.0})["gains.p"] == camera.values["gains.p"] == 10.0, "within the limits"
    assert tool.set(use_sim_time=True)["use_sim_time"] is camera.values["use_sim_time"] is True
    tool.sees(rate=7, frame="odom", use_sim_time=True, **{"gains.p": 10.0})


def test_setting_parameters_without_events(bridge: RunningBridge, camera: FakeNode) -> None:
    camera.publishes_events = False
    tool = Tool(bridge)
    assert tool.set(rate=7)["rate"] == 7
    tool.sees(rate=7)


def test_a_change_that_ros2_refuses(
    bridge: RunningBridge, camera: FakeNode, capsys: pytest.CaptureFixture[str]
) -> None:
    camera.refuse = lambda name, value: "it is even" if value == 4 else ""
    tool = Tool(bridge)
    held = tool.set(rate=4, frame="odom")
    assert (held["rate"], held["frame"]) == (5, "odom"), "what holds now"
    log = capsys.readouterr().err
    assert re.search(r"\[ERROR\].*/camera of ROS 2 refuses to set rate to 4: it is even", log), (
        "ROS 2's reason is there"
    )
    tool.sees(rate=5, frame="odom")


def test_changes_made_in_ros2(bridge: RunningBridge, camera: FakeNode) -> None:
    tool = Tool(bridge)
    tool.config()
    wait_until(lambda: camera.peer.graph.topic("/parameter_events").subscribers, "the bridge subscribes")
    camera.change("rate", 3)
    tool.sees(rate=3)
    camera.change("limits", [5.0])
    camera.peer.send(*foreign_event(camera))
    camera.change("rate", 9)
    tool.sees(rate=9)
    assert tool.config()["frame"] == "map"
    assert len(camera.asked) == 3, "it was not asked"


def foreign_event(camera: FakeNode) -> tuple[Any, bytes]:
    """Return an event of another node with a parameter of the same name."""
    return EVENTS, camera.encoding.event("/other", {}, {"frame": "other"}, {})


def test_parameters_come_and_go(bridge: RunningBridge, camera: FakeNode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconfigured, "REFRESH_PAUSE", 0.1)
    tool = Tool(bridge)
    tool.config()
    wait_until(lambda: camera.peer.graph.topic("/parameter_events").subscribers, "the bridge subscribes")
    camera.values["speed"] = 1.0
    camera.say(new={"speed": 1.0})
    tool.sees(speed=1.0)
    assert tool.description()["speed"]["type"] == "double"
    camera.values["speed"] = "fast"
    camera.say(changed={"speed": "fast"})
    tool.sees(speed="fast")
    del camera.values["frame"]
    camera.say(deleted={"frame": "map"})
    wait_until(lambda: "frame" not in tool.config(), "it is gone")
    assert tool.description()["speed"]["type"] == "str"


def test_only_named_nodes_are_servers(bridge: RunningBridge, make_ros2: Callable[..., FakeNode]) -> None:
    make_ros2("/other", {"rate": 1})
    camera = make_ros2()
    Tool(bridge).config()
    assert "/other/set_parameters" not in bridge.services()
    assert not camera.peer.graph.service("/other/get_parameters").clients


def test_another_server_in_ros1(bridge: RunningBridge, make_ros2: Callable[..., FakeNode]) -> None:
    own = bridge.node.advertise_service("/camera/set_parameters", "std_srvs/Empty", lambda _: None)
    make_ros2()
    wait_until(lambda: "/camera" in bridge.status()["problems"], "the status says it")
    assert "/user provides /camera/set_parameters in ROS 1 already" in bridge.status()["problems"]["/camera"]
    own.shutdown()
    assert Tool(bridge).config()["rate"] == 5


def test_a_node_that_does_not_answer(bridge: RunningBridge, make_ros2: Callable[..., FakeNode]) -> None:
    bad = make_ros2("/bad", {"rate": 1})
    bad.hooks["list_parameters"] = lambda request: None
    wait_until(lambda: "/bad" in bridge.status()["problems"], "the status says it")
    assert bridge.status()["problems"]["/bad"].startswith("node /bad of ROS 2, list_parameters: ")
    make_ros2()
    assert Tool(bridge).config()["rate"] == 5, "others do not wait"
    assert "/bad/set_parameters" not in bridge.services()


def pick(response: Any, request: Any) -> Any:
    return response


@pytest.mark.parametrize(
    ("service", "response", "problem"),
    [
        ("list_parameters", b"", "cannot convert"),
        ("list_parameters", b"\0\1\0\0\xff\xff\xff\xff", "cannot convert"),
        ("list_parameters", bytes(5 << 20), "too large"),
        ("list_parameters", 1001, "has 1001 parameters; at most 1000 can be used"),
        ("describe_parameters", [], "responded about 0 parameters, not 1"),
        ("get_parameters", [], "responded about 0 parameters, not 1"),
    ],
)
def test_hostile_answers(
    bridge: RunningBridge, make_ros2: Callable[..., FakeNode], service: str, response: Any, problem: str
) -> None:
    bad = make_ros2("/bad", {"rate": 1})
    good = bad.encoding
    if isinstance(response, int):
        response = good.make("msg/ListParametersResult", [f"p{number}" for number in range(response)], [])
    bad.hooks[service] = partial(pick, response)
    wait_until(lambda: problem in bridge.status()["problems"].get("/bad", ""), "the status says it")
    assert "/bad/set_parameters" not in bridge.services()


@pytest.mark.slow
def test_hostile_answers_to_a_change(bridge: RunningBridge, camera: FakeNode) -> None:
    tool = Tool(bridge)
    tool.config()
    responses: list[Any] = [b"\0\1\0\0\xff\xff\xff\x7f", []]
    for response in responses:
        camera.hooks["set_parameters"] = partial(pick, response)
        with pytest.raises(ServiceError, match="node /camera of ROS 2"):
            tool.set(rate=7)
    camera.hooks.clear()
    camera.publishes_events = False
    # A value of another type than before, under the name of a number: it is described anew.
    camera.hooks["get_parameters"] = lambda request: [camera.encoding.value("x") for _ in request.names]
    assert tool.set(rate=7)["rate"] == 5
    wait_until(lambda: tool.description()["rate"]["type"] == "str", "it is a string")


def test_hostile_events(bridge: RunningBridge, camera: FakeNode) -> None:
    tool = Tool(bridge)
    tool.config()
    wait_until(lambda: camera.peer.graph.topic("/parameter_events").subscribers, "the bridge subscribes")
    for body in (b"", b"\0\1\0\0", b"\0\1\0\0" + b"\xff" * 100, bytes(5 << 20)):
        camera.peer.send(EVENTS, body)
    camera.change("rate", 3)
    tool.sees(rate=3)


def test_another_version_of_rcl_interfaces(bridge: RunningBridge, make_ros2: Callable[..., FakeNode]) -> None:
    make_ros2("/bad", {"rate": 1}, hashes={**HASHES, "get_parameters": "RIHS01_" + "0" * 64})
    wait_until(lambda: "/bad" in bridge.status()["problems"], "the status says it")
    assert "another version of rcl_interfaces" in bridge.status()["problems"]["/bad"]


# pyros1 bridge param --------------------------------------------------------------------------------------------------


def ask(bridge: RunningBridge, name: str = "", site: str = "ros2") -> Any:
    """Ask as the command does."""
    with bridge.node.service(f"/bridge_ros2/{PARAMETER_SERVICE}", PARAMETERS_CLASS) as client:
        return decode_parameter_response(
            client.call(AnyMsg(encode_parameter_request(ParameterRequest(site, name))), PATIENCE)._buff
        )


def test_reading_parameters(bridge: RunningBridge, make_ros2: Callable[..., FakeNode]) -> None:
    values = {**VALUES, "bytes": b"\0\xff", "flags": [True, False], "many": [1, 1 << 40], "words": ["a", "b\x01"]}
    node = make_ros2("/arm/driver", values, SAID)
    wait_until(lambda: ask(bridge) == ["/arm/driver"], "the node is known")
    expected = {**values, "bytes": [0, 255]}
    del expected["unset"]
    answer = ask(bridge, "/arm/driver")
    assert answer == expected and [*answer] == sorted(expected)
    for name, value in expected.items():
        assert ask(bridge, f"/arm/driver/{name}") == value, name
    assert isinstance(ask(bridge, "/arm/driver/gains.p"), float)
    clients = [client.node_name for client in node.peer.graph.service("/arm/driver/get_parameters").clients]
    assert clients == ["bridge"]
    assert json.dumps(answer)


def test_a_bound_for_the_nodes_that_are_asked(
    bridge: RunningBridge, make_ros2: Callable[..., FakeNode], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exchange, "MAX_ASKED", 1)
    arm, leg = make_ros2("/arm", {"speed": 1}), make_ros2("/leg", {"speed": 2})
    wait_until(lambda: ask(bridge) == ["/arm", "/leg"], "both are known")
    assert (ask(bridge, "/arm/speed"), ask(bridge, "/leg/speed")) == (1, 2)
    wait_until(lambda: not arm.peer.graph.service("/arm/get_parameters").clients, "the first one's client has ended")
    assert leg.peer.graph.service("/leg/get_parameters").clients


def refused(bridge: RunningBridge, name: str, site: str = "ros2") -> str:
    with pytest.raises(ServiceError) as error:
        ask(bridge, name, site)
    assert error.value.answer is not None
    return error.value.answer.decode()


def test_what_cannot_be_read(bridge: RunningBridge, make_ros2: Callable[..., FakeNode]) -> None:
    assert refused(bridge, "/x", "red") == "there is no site red"
    node = make_ros2("/arm", {"speed": 1, "unset": None})
    wait_until(lambda: ask(bridge), "the node is known")
    text = refused(bridge, "/arm/sped")
    assert "parameter sped of node /arm of ROS 2 is not there (did you mean 'speed'?)" in text
    assert "pyros1 bridge param ros2: /arm" in text
    assert "parameter unset of node /arm of ROS 2 has no value" in refused(bridge, "/arm/unset")
    assert "/army is neither a ROS 2 node whose parameters may be read" in refused(bridge, "/army")
    assert "is not the full name" in refused(bridge, "/a\nb")
    node.hooks["get_parameters"] = lambda request: []
    assert refused(bridge, "/arm").startswith("node /arm of ROS 2 responded about 0 parameters, not 2")


def test_rules_for_reading(endpoint: str, tmp_path: Path) -> None:
    bridge = RunningBridge(tmp_path, Ros2Rules([], ["/arm/**"], ["/legs"]), listen=[endpoint])
    peers = []
    try:
        for name in ("/arm", "/legs", "/head"):
            peers.append(FakeNode(Ros2Peer(endpoint), name, {"rate": 1}))
        wait_until(lambda: ask(bridge) == ["/arm", "/legs"], "the nodes are known")
        assert "is neither a ROS 2 node whose parameters may be read" in refused(bridge, "/head/rate")
    finally:
        for each in peers:
            each.close()
            each.peer.session.close()
        bridge.close()
