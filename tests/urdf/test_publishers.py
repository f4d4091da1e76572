"""The nodes robot_state_publisher and joint_state_publisher, beside nodes of the test.

interop/tf/test_state_publishers.py compares them with stock's.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest
from robots import ALL, joint, pair

from pyros1.ground.timing import Time
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node
from pyros1.urdf import joint_publisher
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.model import UrdfError
from pyros1.urdf.reading import read_robot
from pyros1.urdf.state_publisher import RobotStatePublisher, Settings, deprecated_main, frame_name, read_settings

PATIENCE = 20.0
Make = Callable[..., Node]


class Ear:
    """Hears a topic."""

    def __init__(self, node: Node, topic: str, kind: type[Any]) -> None:
        self.came: Queue[Any] = Queue()
        node.subscribe(topic, kind, self.came.put)

    def next(self) -> Any:
        return self.came.get(timeout=PATIENCE)


class Arm:
    """A robot_state_publisher, who tells it positions, and who hears it."""

    def __init__(self, make_node: Make, text: str = ALL, **given: Any) -> None:
        self.node = make_node("tool")
        self.user = make_node("user")
        self.fixed = Ear(self.user, "/tf_static", TFMessage)
        self.moving = Ear(self.user, "/tf", TFMessage)
        RobotStatePublisher(self.node, Kinematics(read_robot(text)), Settings(**given))
        self.publisher = self.user.advertise("joint_states", JointState)
        assert self.publisher.wait_for_subscribers(timeout=PATIENCE)

    def say(self, at: float, *names: str, positions: list[float] | None = None) -> None:
        message = JointState(name=list(names), position=[0.5] * len(names) if positions is None else positions)
        message.header.stamp = Time.from_sec(at)
        self.publisher.publish(message)

    def said(self) -> tuple[float, list[str]]:
        found = self.moving.next().transforms
        return found[0].header.stamp.to_sec(), [each.child_frame_id for each in found]


def test_links_move_and_fixed_ones_are_latched(make_node: Make, transport: str) -> None:
    arm = Arm(make_node)
    assert {(each.header.frame_id, each.child_frame_id) for each in arm.fixed.next().transforms} == {
        ("c", "d"),
        ("base", "f"),
    }
    arm.say(100.25, "turn", "lift", "nobody")
    assert arm.said() == (100.25, ["a", "c", "g", "h"])
    late = Ear(make_node("late"), "/tf_static", TFMessage)
    assert len(late.next().transforms) == 2


def test_the_rate_is_bounded_for_each_joint(make_node: Make) -> None:
    arm = Arm(make_node, publish_frequency=10.0)
    for at, name in [(100.0, "lift"), (100.05, "lift"), (100.06, "wheel"), (100.25, "lift"), (99.0, "wheel")]:
        arm.say(at, name)
    arm.say(101.0, "soft")
    assert [arm.said() for _ in range(4)] == [(100.0, ["c"]), (100.06, ["b"]), (100.25, ["c"]), (101.0, ["i"])]


def test_every_message_counts_if_one_wants_that(make_node: Make) -> None:
    arm = Arm(make_node, ignore_timestamp=True)
    for at in (100.0, 100.0, 99.0):
        arm.say(at, "lift")
    assert [arm.said()[0] for _ in range(3)] == [100.0, 100.0, 99.0]


def test_what_cannot_be_used_is_told(make_node: Make) -> None:
    arm = Arm(make_node)
    log = Ear(arm.user, "/rosout", type_of("rosgraph_msgs/Log"))
    until = time.monotonic() + PATIENCE
    while log.came.empty():  # until the link is there
        assert time.monotonic() < until
        arm.node.log.warn("begin")
        time.sleep(0.02)
    arm.say(1.0, "turn", "lift", positions=[1.0])
    arm.say(1.0, "turn", positions=[])
    arm.say(1.0)
    arm.say(1.0, "lift", *map(str, range(2000)))
    arm.say(2.0, "turn", positions=[float("inf")])
    arm.say(3.0, "nobody")
    arm.say(4.0, "lift")
    assert arm.said() == (4.0, ["c"])
    told = ""
    while "nobody" not in told:
        told += log.next().msg
    assert "ignored an invalid JointState message" in told
    assert 'about joint(s) "turn"(,...) whose position member was empty' in told
    assert "joint states with positions that are NaN or infinite" in told
    assert "seconds old" in told


def type_of(name: str) -> Any:
    from pyros1.msgs import load_message

    return load_message(name)


def test_fixed_links_on_tf_and_a_prefix(make_node: Make) -> None:
    arm = Arm(make_node, use_tf_static=False, prefix="one", publish_frequency=200.0)
    before = arm.node.now().to_sec()
    found = arm.moving.next().transforms
    assert {each.header.frame_id for each in found} == {"one/c", "one/base"}
    assert found[0].header.stamp.to_sec() > before + 0.4
    assert arm.fixed.came.empty()
    assert [frame_name("", "/a"), frame_name("/p", "a"), frame_name("p", "/a")] == ["a", "p/a", "a"]


def test_time_that_jumps_back(make_node: Make) -> None:
    setter = make_node("setter")
    setter.params["/use_sim_time"] = True
    clock = setter.advertise("/clock", type_of("rosgraph_msgs/Clock"), latch=True)
    arm = Arm(make_node)

    def now(seconds: float) -> None:
        clock.publish(Time.from_sec(seconds))
        until = time.monotonic() + PATIENCE
        while arm.node.now().to_sec() != seconds:
            assert time.monotonic() < until
            time.sleep(0.01)

    now(100.0)
    arm.say(100.0, "lift")
    assert arm.said() == (100.0, ["c"])
    now(50.0)
    arm.say(50.0, "lift")  # older than the last one, and yet new
    assert arm.said() == (50.0, ["c"])


def test_parameters_of_the_node(make_node: Make) -> None:
    node = make_node("tool")
    assert read_settings(node) == Settings()
    node.params["~publish_frequency"] = 5
    node.params["~use_tf_static"] = False
    node.params["~ignore_timestamp"] = True
    node.params["/tf_prefix"] = "p"
    assert read_settings(node) == Settings(5.0, True, False, "p")
    node.params["~publish_frequency"] = "often"
    with pytest.raises(UrdfError, match="publish_frequency must be a number"):
        read_settings(node)


def test_many_names_are_forgotten_again(make_node: Make) -> None:
    arm = Arm(make_node)
    for index in range(50):
        arm.say(100.0 + index, "lift", *(f"made_up_{index}_{number}" for number in range(500)))
    seen = [arm.said() for _ in range(50)]
    assert seen[-1] == (149.0, ["c"])


def test_joints_are_published_and_moved(make_node: Make) -> None:
    node, user = make_node("tool"), make_node("user")
    node.params["robot_description"] = ALL
    node.params["~source_list"] = ["more", "joint_states"]  # the last is our own
    node.params["~rate"] = 100
    heard = Ear(user, "/joint_states", JointState)
    publisher = joint_publisher.make_publisher(node)
    running = threading.Thread(target=publisher.run)
    running.start()
    assert heard.next().position == (0.0, 0.0, 0.75, 0.25, 0.75, 0.6)
    for topic, position in (("more", 1.5), ("/tool/sliders", -0.5)):
        source = user.advertise(topic, JointState)
        assert source.wait_for_subscribers(timeout=PATIENCE)
        source.publish(JointState(name=["wheel"], position=[position]))
        while (message := heard.next()).position[1] != position:
            assert message.name == ("turn", "wheel", "lift", "twin", "another", "soft") or list(message.name)
        assert message.header.stamp.to_sec() > 0
    node.shutdown()
    running.join(PATIENCE)


def test_a_robot_without_a_description(make_node: Make) -> None:
    node = make_node("tool")
    with pytest.raises(UrdfError, match="Could not find parameter robot_description"):
        joint_publisher.make_publisher(node)
    node.params["robot_description"] = 5
    with pytest.raises(UrdfError, match="must be a string"):
        joint_publisher.make_publisher(node)
    node.params["~robot_description"] = pair(joint())
    assert joint_publisher.make_publisher(node)


@pytest.mark.parametrize("program", ["state_publisher", "joint_publisher"])
def test_programs_say_why_they_end(program: str, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    from importlib import import_module

    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    assert import_module(f"pyros1.urdf.{program}").main([program]) == 1


def test_the_old_name_of_robot_state_publisher(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Feature: robot_state_publisher under its old name, state_publisher"""
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    assert deprecated_main(["state_publisher", "__name:=rsp"]) == 1
    lines = capfd.readouterr().err.splitlines()
    assert "state_publisher is deprecated: use robot_state_publisher" in lines[0]
    assert "robot_description" in lines[1]  # which is missing
