"""What pages ask for once."""

from __future__ import annotations

import pkgutil
import queue
import threading
from collections.abc import Callable
from importlib import import_module
from typing import Any

import pytest

from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.msgs import AnyMsg, Message, from_definition
from pyros1.msgs.std_srvs.srv import SetBool, SetBoolResponse
from pyros1.web import calls
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError

PATIENCE = 20.0
Make = Callable[..., Any]


def test_forms_stay_in_step(robot: Robot) -> None:
    form = calls.run(robot, "topics.form", {"type": "std_msgs/Header"})
    text = calls.run(robot, "forms.yaml", {"value": {**form["default"], "frame_id": "map"}})
    assert text == "seq: 0\nstamp: {secs: 0, nsecs: 0}\nframe_id: map\n"
    value = calls.run(robot, "forms.value", {"type": "std_msgs/Header", "yaml": "stamp: now\n"})
    assert value == {"seq": 0, "stamp": "now", "frame_id": ""}
    request = {"type": "std_srvs/SetBool", "part": "request", "yaml": "data: true"}
    assert calls.run(robot, "forms.value", request) == {"data": True}


def test_whole_numbers_that_javascript_would_round(robot: Robot, make_node: Make) -> None:
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    make_node("ear").subscribe("/number", "std_msgs/UInt64", heard.put)
    most = 2**64 - 1
    value = calls.run(robot, "forms.value", {"type": "std_msgs/UInt64", "yaml": f"data: {most}"})
    assert value == {"data": str(most)}  # as text, the page gives it back as it is
    calls.run(robot, "topics.publish", {"topic": "/number", "type": "std_msgs/UInt64", "value": value})
    assert heard.get(timeout=PATIENCE).data == most
    with pytest.raises(Error, match="data"):
        calls.run(robot, "topics.publish", {"topic": "/number", "type": "std_msgs/UInt64", "value": {"data": "x"}})


def test_files_of_rviz(robot: Robot) -> None:
    displays = "[{Class: rviz/Path, Topic: plan}, {Class: rviz/Path, Topic: /a//b/}, {Class: x/Y}]"
    file = f"Visualization Manager: {{Displays: {displays}}}"
    found = calls.run(robot, "scene.rviz", {"text": file})
    assert found["settings"]["topics"] == ["/plan", "/a/b"] and found["notes"] == ["Y: unsupported display x/Y"]
    with pytest.raises(Error, match="is not YAML"):
        calls.run(robot, "scene.rviz", {"text": "["})


def test_types_are_proposed(robot: Robot) -> None:
    assert "geometry_msgs/" in calls.run(robot, "topics.types", {"begin": "geo"})
    assert calls.run(robot, "topics.types", {"begin": "std_msgs/Float6"}) == [
        "std_msgs/Float64",
        "std_msgs/Float64MultiArray",
    ]
    assert calls.run(robot, "topics.types", {"begin": "no_such/"}) == []


@pytest.mark.parametrize(
    ("name", "args"),
    [
        ("forms.value", {"type": "std_msgs/Header", "yaml": "a: 1"}),
        ("forms.value", {"type": "std_msgs/Header", "yaml": "[: "}),
        ("forms.value", {"type": "std_msgs/Header", "yaml": "stamp: soon"}),
        ("forms.value", {"type": "no/Such", "yaml": ""}),
        ("forms.yaml", {"value": 5}),
        ("services.types", {"services": "all"}),
        ("params.get", {"name": "/nothing"}),
        ("actions.form", {"action": "/nothing"}),
        ("nodes.info", {"node": "/nothing"}),
    ],
)
def test_mistakes_are_errors_that_can_be_shown(robot: Robot, name: str, args: dict[str, Any]) -> None:
    with pytest.raises(Error):
        calls.run(robot, name, args)


CHANGING = [
    f"{file.name}.{name}"
    for file in pkgutil.iter_modules(calls.__path__)
    for name in sorted(import_module(f"{calls.__name__}.{file.name}").CHANGES)
]


@pytest.mark.parametrize("name", CHANGING)
def test_a_read_only_server_changes_nothing(make_robot: Make, name: str) -> None:
    with pytest.raises(RequestError, match="read-only"):
        calls.run(make_robot(read_only=True), name, {})


@pytest.mark.parametrize(
    ("name", "args"),
    [
        ("topics.publish", {"topic": "/b", "type": "std_msgs/Empty", "value": {}}),
        ("services.call", {"service": "/b", "value": {}}),
        ("params.get", {"name": "/b"}),
        ("params.put", {"name": "/b", "yaml": "1"}),
        ("params.delete", {"name": "/b"}),
        ("reconfigure.update", {"node": "/b", "values": {}, "types": {}}),
        ("actions.send", {"action": "/b", "value": {}}),
        ("actions.cancel", {"action": "/b", "id": ""}),
    ],
)
def test_what_may_not_be_seen_cannot_be_changed(make_robot: Make, name: str, args: dict[str, Any]) -> None:
    with pytest.raises(RequestError, match="this server does not show"):
        calls.run(make_robot(topics=("/a/*",)), name, args)


def test_services_have_types_and_can_be_called(make_node: Make, robot: Robot) -> None:
    node = make_node("switch")
    node.advertise_service("/switch", SetBool, lambda request: SetBoolResponse(success=request.data, message="done"))
    assert calls.run(robot, "services.types", {"services": ["/switch", "/no"]}) == {
        "/switch": "std_srvs/SetBool",
        "/no": "",
    }
    form = calls.run(robot, "services.form", {"service": "/switch"})
    assert form["request"]["fields"] == [["data", "bool", None, None]]
    answer = calls.run(robot, "services.call", {"service": "/switch", "value": {"data": True}})
    assert answer["value"]["fields"] == [["success", "bool", True], ["message", "string", "done"]]
    assert 0 <= answer["seconds"] < PATIENCE


def test_parameters_are_set_and_deleted(make_node: Make, robot: Robot) -> None:
    node = make_node("reader")
    calls.run(robot, "params.put", {"name": "/a/list", "yaml": "[1, 2.5, x]"})
    assert node.params["/a/list"] == [1, 2.5, "x"]
    assert calls.run(robot, "params.get", {"name": "/a/list"}) == "[1, 2.5, x]\n"
    assert calls.run(robot, "params.tree", {})["/a/list"] == [1, 2.5, "x"]
    calls.run(robot, "params.delete", {"name": "/a"})
    assert "/a/list" not in node.params


def test_nodes_loggers_and_their_end(make_node: Make, robot: Robot) -> None:
    node = make_node("worker")
    ended = threading.Event()
    node.on_shutdown(ended.set)
    facts = calls.run(robot, "nodes.info", {"node": "/worker"})
    assert facts["pid"] > 0 and "/worker/get_loggers" in facts["services"]
    logger = calls.run(robot, "nodes.loggers", {"node": "/worker"})[0][0]
    calls.run(robot, "nodes.set_level", {"node": "/worker", "logger": logger, "level": "error"})
    assert calls.run(robot, "nodes.loggers", {"node": "/worker"})[0][1].lower() == "error"
    calls.run(robot, "nodes.kill", {"node": "/worker"})
    assert ended.wait(PATIENCE)
    with pytest.raises(RequestError, match="belongs to this page's server"):
        calls.run(robot, "nodes.kill", {"node": robot.node.name})


def test_who_tells_the_servers_node_to_end_is_heard(make_node: Make, robot: Robot) -> None:
    killed = threading.Event()
    robot.on_killed = killed.set
    other = Graph(make_node("other").master).node_api(robot.graph.node_uri(robot.node.name) or "", PATIENCE)
    other.shutdown("user request")
    other.close()
    assert killed.wait(PATIENCE)
    with pytest.raises(RequestError, match="requested to shut down"):
        robot.listen("/topic1", print)


@pytest.mark.slow
def test_types_that_are_not_installed_come_with_their_messages(make_node: Make, robot: Robot) -> None:
    parts = "=" * 80 + "\nMSG: far_msgs/Part\nbool on"
    cls = from_definition("far_msgs/Odd", f"int32 kind\nint32 KIND_A=1\nfar_msgs/Part[] parts\n{parts}")
    node = make_node("far")
    register(make_node, "/quiet", from_definition("far_msgs/Quiet", "int32 a"))
    register(make_node, "/odd", cls).publish(cls(kind=1))
    form = calls.run(robot, "topics.form", {"topic": "/odd"})
    assert form["fields"] == [
        ["kind", "int32", None, [["KIND_A", 1]]],
        ["parts", "far_msgs/Part[]", [["on", "bool", None, None]], None],
    ]
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    node.subscribe("/again", cls, heard.put)
    value = calls.run(robot, "forms.value", {"type": "far_msgs/Odd", "yaml": "parts: [{'on': true}]"})
    assert value == {"kind": 0, "parts": [{"on": True}]}
    calls.run(robot, "topics.publish", {"topic": "/again", "type": "far_msgs/Odd", "value": value})
    assert heard.get(timeout=PATIENCE).parts[0].on
    with pytest.raises(Error, match="no message with its definition has been received on /quiet"):
        calls.run(robot, "topics.form", {"topic": "/quiet"})


def register(make_node: Make, topic: str, cls: type[Message]) -> Any:
    """Return a latched publisher that the master knows, because a subscriber has found it."""
    make_node(f"ear_{topic[1:]}").subscribe(topic, AnyMsg, lambda message: None)
    publisher = make_node(f"mouth_{topic[1:]}").advertise(topic, cls, latch=True)
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    return publisher
