"""The exercises: what is missing is said, and what is done is seen.

Feature: the guide
"""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1 import actions
from pyros1.guide import checks
from pyros1.guide.checks import CHECKS, CheckContext, check
from pyros1.guide.documents import steps
from pyros1.master.server import Master
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciResult
from pyros1.msgs.geometry_msgs.msg import TransformStamped, Twist
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.msgs.std_srvs.srv import Empty, Trigger, TriggerResponse
from pyros1.node.log.levels import level_from_name
from pyros1.tf import StaticTransformBroadcaster
from pyros1.urdf.model import UrdfError

pytestmark = pytest.mark.once

Check = Callable[[int], str]
MakeNode = Callable[..., Any]


@pytest.fixture
def ask(environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Check:
    """Return what is missing in a step's exercise."""
    monkeypatch.setattr(checks, "MESSAGE_TIMEOUT", 1.5)
    return lambda number: check(number, {**os.environ, **environ, "ROS_PACKAGE_PATH": str(tmp_path)}, tmp_path)


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """The rates that are measured."""
    rates: dict[str, float] = {}
    monkeypatch.setattr(CheckContext, "measure_rate", lambda self, topic: rates[topic])
    return rates


def publish(make_node: MakeNode, name: str, topic: str, message: Any, namespace: str | None = None) -> Any:
    publisher = make_node(name, namespace=namespace).advertise(topic, type(message), latch=True)
    publisher.publish(message)
    return publisher


def test_each_step_has_an_exercise_and_a_check() -> None:
    assert len(CHECKS) == len(steps()) >= 14
    assert all(len(step.exercise) > 20 for step in steps())
    assert [step.number for step in steps()] == list(range(1, len(CHECKS) + 1))


def test_a_package(ask: Check, tmp_path: Path) -> None:
    assert "there is no package my_messages here" in ask(1)
    folder = tmp_path / "my_messages"
    (folder / "msg").mkdir(parents=True)
    (folder / "package.xml").write_text(
        "<package><name>my_messages</name><version>1.0.0</version><description>d</description>"
        "<maintainer email='a@b.c'>a</maintainer><license>BSD</license></package>"
    )
    assert "no message type Pair" in ask(1)
    (folder / "msg" / "Pair.msg").write_text("float64 a\nint32 b\n")
    assert "but it has float64 a, int32 b" in ask(1)
    (folder / "msg" / "Pair.msg").write_text("float64 a\nfloat64 b\n")
    assert ask(1) == ""


def test_a_publisher(ask: Check, make_node: MakeNode, measured: dict[str, float]) -> None:
    assert ask(2) == "no node publishes /topic2"
    wrong = publish(make_node, "wrong", "/topic2", String())
    assert "but its type is std_msgs/String" in ask(2)
    wrong.unregister()
    publish(make_node, "right", "/topic2", Float64())
    measured["/topic2"] = 1.0
    assert "its rate is 1.0 Hz" in ask(2)
    measured["/topic2"] = 9.9
    assert ask(2) == ""


def test_a_rate_is_measured(make_node: MakeNode, environ: dict[str, str], tmp_path: Path) -> None:
    publisher = make_node("fast").advertise("/a", Float64)
    timer = make_node("clock").timer(0.01, lambda event: publisher.publish(data=1.0))
    with CheckContext(environ, tmp_path) as looking:
        assert looking.measure_rate("/a", 0.5) > 2.0
        assert looking.measure_rate("/nobody", 0.01) == 0.0
    timer.shutdown()


@pytest.mark.slow
def test_publishing_by_hand(ask: Check, make_node: MakeNode) -> None:
    assert ask(3) == "no node publishes /topic1"
    publisher = publish(make_node, "minimal_publisher", "/topic1", Float64(1.0))
    assert "the minimal_subscriber is not running" in ask(3)
    make_node("minimal_subscriber").subscribe("/topic1", Float64, lambda message: None)
    assert "no node publishes 3.5" in ask(3)
    publisher.publish(data=3.5)
    assert ask(3) == ""


def test_a_launch_file(ask: Check, make_node: MakeNode) -> None:
    assert "no node publishes /left/topic1" in ask(4)
    publish(make_node, "third", "/left/topic1", Float64(), "/left")
    assert "is published by /left/third, but the node in the group should be named second" in ask(4)
    publish(make_node, "second", "/left/topic1", Float64(), "/left")
    assert ask(4) == ""


def test_a_silent_node(ask: Check, make_node: MakeNode) -> None:
    assert "is not running" in ask(5)
    node = make_node("minimal_subscriber")
    assert "the logger's level is info" in ask(5)
    node.log.level = level_from_name("error")
    assert ask(5) == ""


def test_a_recording(ask: Check, tmp_path: Path) -> None:
    assert ask(6) == "there is no both.bag in this folder."
    (tmp_path / "both.bag.active").touch()
    assert "still being recorded" in ask(6)
    with pyros1.bag.open(tmp_path / "both.bag", "w") as bag:
        bag.write("/topic1", Float64(1.0), 1.0)
    assert "/rosout is not in both.bag" in ask(6)
    with pyros1.bag.open(tmp_path / "both.bag", "a") as bag:
        bag.write("/rosout", Log(), 2.0)
    assert ask(6) == ""


@pytest.mark.slow
def test_a_mass_that_stands_still(ask: Check, make_node: MakeNode) -> None:
    assert "no node publishes /velocity: pyros1 launch" in ask(7)
    velocity = publish(make_node, "minimal_simulator", "/velocity", Float64(0.9))
    assert "no node publishes /vel_cmd" in ask(7)
    command = publish(make_node, "hand", "/vel_cmd", Float64(1.0))
    assert "the commanded velocity is 1 m/s:" in ask(7)
    command.publish(data=0.0)
    assert "the mass is still moving" in ask(7)
    velocity.publish(data=0.01)
    assert ask(7) == ""


def test_a_parameter(ask: Check, make_node: MakeNode, measured: dict[str, float]) -> None:
    assert "/minimal_publisher/rate is not set: pyros1 run" in ask(8)
    node = make_node("minimal_publisher")
    node.params["~rate"] = 5
    assert ask(8) == "no node publishes /topic1"
    node.advertise("/topic1", Float64)
    measured["/topic1"] = 1.0
    assert "start the publisher again" in ask(8)
    by_hand = make_node("by_hand").advertise("/topic1", Float64)
    assert ask(8).endswith("is 1.0 Hz: other nodes publish on /topic1, too; stop /by_hand")
    by_hand.unregister()
    measured["/topic1"] = 5.0
    assert ask(8) == ""


@pytest.fixture
def stopwatch(make_node: MakeNode) -> Iterator[tuple[Any, list[str]]]:
    """A node that reads what the test says."""
    said = ["7 s"]
    node = make_node("stopwatch")
    node.advertise_service("~read", Trigger, lambda request: TriggerResponse(True, said[-1]))
    yield node, said


def test_a_service(ask: Check, stopwatch: tuple[Any, list[str]]) -> None:
    node, said = stopwatch
    assert "there is no service /stopwatch/reset" in ask(9)
    node.advertise_service("~reset", Empty, lambda request: {})
    assert "should return 0, but it returns '7 s'" in ask(9)
    said.append("0 s")
    assert ask(9) == ""


def transform(parent: str, child: str, z: float) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.translation.z = z
    message.transform.rotation.w = 1.0
    return message


@pytest.mark.slow
def test_a_frame(ask: Check, make_node: MakeNode) -> None:
    assert ask(10) == "no node publishes the frame lamp; the frames are: none"
    frames = StaticTransformBroadcaster(make_node("frames"))
    frames.send_transform([transform("table", "lamp", 0.2), transform("world", "camera", 0.3)])
    assert ask(10) == "lamp and camera are not connected: pyros1 tf tree"
    frames.send_transform(transform("table", "camera", 0.3))
    assert ask(10) == "the parent of camera should be lamp, but it is table"
    frames.send_transform(transform("lamp", "camera", 1.0))
    assert ask(10) == "camera should be at 0 0 0.1 in lamp, but it is at 0 0 1"
    frames.send_transform(transform("lamp", "camera", 0.1))
    assert ask(10) == ""


ARM = '<robot name="r"><link name="base"/><link name="arm"/>{}<joint name="shoulder" type="fixed"><parent link="base"/>\
<child link="arm"/></joint></robot>'
WRIST = '<link name="hand"/><joint name="{}" type="continuous"><parent link="arm"/><child link="hand"/>\
<origin xyz="{} 0 0"/><axis xyz="0 1 0"/></joint>'


def test_a_robot(ask: Check, make_node: MakeNode) -> None:
    node = make_node("robot")
    with pytest.raises(UrdfError, match="Could not find parameter robot_description"):
        ask(11)
    node.params["/robot_description"] = ARM.format("")
    assert "the robot has no link hand, only base, arm" in ask(11)
    node.params["/robot_description"] = ARM.format(WRIST.format("elbow", 0.5))
    assert "the robot has no joint wrist, only elbow, shoulder" in ask(11)
    node.params["/robot_description"] = ARM.format(WRIST.format("wrist", 5))
    assert ask(11) == "the origin of wrist should be 0.5 0 0, but it is 5 0 0"
    node.params["/robot_description"] = ARM.format(WRIST.format("wrist", 0.5))
    assert "no node publishes the position of the hand" in ask(11)
    StaticTransformBroadcaster(node).send_transform([transform("base", "arm", 0.1), transform("arm", "hand", 0.0)])
    assert ask(11) == ""


def test_an_action(ask: Check, make_node: MakeNode, monkeypatch: pytest.MonkeyPatch) -> None:
    assert ask(12) == "there is no server for the action drive: pyros1 run my_robot driver"
    does = ["succeed"]
    node = make_node("driver")

    def drive(goal: Any) -> Any:
        if goal.goal.order > 0 or does[-1] == "succeed":
            return FibonacciResult()
        return goal.abort(text=does[-1])

    with actions.SimpleServer(node, "drive", FibonacciAction, drive, frequency=50.0):
        assert "but their type is actionlib_tutorials/FibonacciActionGoal" in ask(12)
        monkeypatch.setattr(checks, "DRIVE_ACTION_TYPE", "actionlib_tutorials/Fibonacci")
        monkeypatch.setattr(checks, "MESSAGE_TIMEOUT", 5.0)
        assert ask(12) == "a goal of -1 m should be aborted, but it succeeded"
        does.append("")
        assert "does not say why" in ask(12)
        does.append("it is negative")
        assert ask(12) == ""


def test_a_second_master(ask: Check, monkeypatch: pytest.MonkeyPatch, free_port: int) -> None:
    monkeypatch.setattr(checks, "SECOND_MASTER_PORT", free_port)
    monkeypatch.setattr(checks, "interface_addresses", lambda: ["127.0.0.1", "10.0.0.1"])
    reached = ["10.0.0.1"]
    monkeypatch.setattr(checks, "accepts_connections", lambda address, port: address in reached)
    assert f"there is no master on port {free_port}: pyros1 core" in ask(13)
    second = Master(port=free_port, bind_host="127.0.0.1")
    second.start()
    try:
        assert "other machines can reach the second master at 10.0.0.1" in ask(13)
        reached.clear()
        assert "no minimal_publisher uses the second master" in ask(13)
        environ = {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port}", "ROS_IP": "127.0.0.1"}
        with pyros1.Node("minimal_publisher", argv=[], environ=environ, handle_signals=False) as node:
            node.advertise("topic1", Float64)
            assert ask(13) == ""
    finally:
        second.stop()


def test_who_answers_at_a_port(free_port: int) -> None:
    assert not checks.accepts_connections("127.0.0.1", free_port)
    with socket.create_server(("127.0.0.1", free_port)):
        assert checks.accepts_connections("127.0.0.1", free_port)


GOOD = """
def test_it(ros_run="", ros_node=""):
    # ros_run: /stopwatch/reset and /stopwatch/read
    assert 1 == 1
"""


@pytest.mark.slow
def test_a_test(ask: Check, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # it would take seconds to load
    assert "there is no my_robot/tests/test_stopwatch.py" in ask(14)
    path = tmp_path / "my_robot" / "tests" / "test_stopwatch.py"
    path.parent.mkdir(parents=True)
    path.write_text("def test_nothing(ros_run): pass\n")
    assert ask(14) == "the test does not contain /stopwatch/reset"
    path.write_text(GOOD.replace("1 == 1", "1 == 2"))
    said = ask(14).splitlines()
    assert re.fullmatch(r"python3 -m pytest my_robot/tests/test_stopwatch.py: 1 failed in .*s", said[0])
    assert [line.split() for line in said[1:]] == [["E", "assert", "1", "==", "2"]]
    path.write_text(GOOD)
    assert ask(14) == ""
    monkeypatch.setattr(checks, "MAX_TEST_SECONDS", 0.01)
    assert ask(14) == "the test did not finish within 0.01 s"


@pytest.mark.slow
def test_a_robot_that_is_driven(ask: Check, make_node: MakeNode) -> None:
    assert "there is no twist_mux with topics" in ask(15)
    node = make_node("twist_mux")
    sources = [{"name": "keyboard", "topic": "key_vel", "priority": 90}]
    node.params["~topics"] = sources
    assert "has no topic nav_vel" in ask(15)
    for priority in (90, "high"):
        node.params["~topics"] = [*sources, {"name": "planner", "topic": "nav_vel", "priority": priority}]
        assert f"the priority of nav_vel, {priority}, should be lower than that of key_vel, 90" in ask(15)
    node.params["~topics"] = [*sources, {"name": "planner", "topic": "nav_vel", "priority": 10}]
    assert "no node publishes /nav_vel: pyros1 topic pub -r 10 nav_vel" in ask(15)
    publish(make_node, "planner", "/nav_vel", Twist())
    node.params["/use_sim_time"] = True  # as the launch file has left it; no clock ticks
    odometry = publish(make_node, "flat_world", "/odom", Odometry())
    assert "the robot does not move" in ask(15)
    moving = Odometry()
    moving.twist.twist.linear.x = 0.2
    odometry.publish(moving)
    assert ask(15) == ""


def test_a_check_without_a_master_fails_at_once(tmp_path: Path, capfd: Any, free_port: int) -> None:
    environ = {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port}", "ROS_HOME": str(tmp_path)}
    with pytest.raises(pyros1.MasterUnreachableError):
        check(2, environ, tmp_path)
    assert capfd.readouterr() == ("", "")  # no warning of a node that keeps trying: the error says it all
