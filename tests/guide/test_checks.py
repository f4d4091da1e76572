"""The exercises: what is missing is said, and what is done is seen."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.guide import checks
from pyros1.guide.checks import CHECKS, Looking, check
from pyros1.guide.text import steps
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.msgs.std_srvs.srv import Empty, Trigger, TriggerResponse
from pyros1.node.log.levels import level_from_name

Check = Callable[[int], str]
MakeNode = Callable[..., Any]


@pytest.fixture
def ask(environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Check:
    """Return what is missing in a step's exercise."""
    monkeypatch.setattr(checks, "PATIENCE", 0.5)
    return lambda number: check(number, {**environ, "ROS_PACKAGE_PATH": str(tmp_path)}, tmp_path)


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """The rates that are measured."""
    rates: dict[str, float] = {}
    monkeypatch.setattr(Looking, "rate", lambda self, topic: rates[topic])
    return rates


def publish(make_node: MakeNode, name: str, topic: str, message: Any, namespace: str | None = None) -> Any:
    publisher = make_node(name, namespace=namespace).advertise(topic, type(message), latch=True)
    publisher.publish(message)
    return publisher


def test_each_step_has_an_exercise_and_a_check() -> None:
    assert len(CHECKS) == len(steps()) >= 9
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
    assert "and has float64 a, int32 b" in ask(1)
    (folder / "msg" / "Pair.msg").write_text("float64 a\nfloat64 b\n")
    assert ask(1) == ""


def test_a_publisher(ask: Check, make_node: MakeNode, measured: dict[str, float]) -> None:
    assert ask(2) == "nobody publishes /topic2"
    wrong = publish(make_node, "wrong", "/topic2", String())
    assert "/topic2 has the type std_msgs/String" in ask(2)
    wrong.unregister()
    publish(make_node, "right", "/topic2", Float64())
    measured["/topic2"] = 1.0
    assert "comes 1.0 times" in ask(2)
    measured["/topic2"] = 9.9
    assert ask(2) == ""


def test_a_rate_is_measured(make_node: MakeNode, environ: dict[str, str], tmp_path: Path) -> None:
    publisher = make_node("fast").advertise("/a", Float64)
    timer = make_node("clock").timer(0.01, lambda event: publisher.publish(data=1.0))
    with Looking(environ, tmp_path) as looking:
        assert looking.rate("/a", 0.5) > 2.0
        assert looking.rate("/nobody", 0.01) == 0.0
    timer.shutdown()


def test_publishing_by_hand(ask: Check, make_node: MakeNode) -> None:
    assert ask(3) == "nobody publishes /topic1"
    publisher = publish(make_node, "minimal_publisher", "/topic1", Float64(1.0))
    assert "the minimal_subscriber does not run" in ask(3)
    make_node("minimal_subscriber").subscribe("/topic1", Float64, lambda message: None)
    assert "nobody sends 3.5" in ask(3)
    publisher.publish(data=3.5)
    assert ask(3) == ""


def test_a_launch_file(ask: Check, make_node: MakeNode) -> None:
    assert "nobody publishes /left/topic1" in ask(4)
    publish(make_node, "third", "/left/topic1", Float64(), "/left")
    assert "is published by /left/third; the node should be named second" in ask(4)
    publish(make_node, "second", "/left/topic1", Float64(), "/left")
    assert ask(4) == ""


def test_a_silent_node(ask: Check, make_node: MakeNode) -> None:
    assert "does not run" in ask(5)
    node = make_node("minimal_subscriber")
    assert "its level is info" in ask(5)
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


def test_a_mass_that_stands_still(ask: Check, make_node: MakeNode) -> None:
    assert "nobody publishes /velocity: pyros1 launch" in ask(7)
    velocity = publish(make_node, "minimal_simulator", "/velocity", Float64(0.9))
    assert "nobody sends a velocity" in ask(7)
    command = publish(make_node, "hand", "/vel_cmd", Float64(1.0))
    assert "the velocity that is sent is 1;" in ask(7)
    command.publish(data=0.0)
    assert "the mass still moves" in ask(7)
    velocity.publish(data=0.01)
    assert ask(7) == ""


def test_a_parameter(ask: Check, make_node: MakeNode, measured: dict[str, float]) -> None:
    assert "/minimal_publisher/rate is None" in ask(8)
    node = make_node("minimal_publisher")
    node.params["~rate"] = 5
    assert ask(8) == "nobody publishes /topic1"
    node.advertise("/topic1", Float64)
    measured["/topic1"] = 1.0
    assert "start the publisher again" in ask(8)
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
    assert "after a reset it says '7 s'" in ask(9)
    said.append("0 s")
    assert ask(9) == ""


def test_a_check_without_a_master(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free_port: int) -> None:
    monkeypatch.setattr(checks, "PATIENCE", 0.1)
    environ = {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port}", "ROS_HOME": str(tmp_path)}
    with pytest.raises(pyros1.MasterUnreachableError):
        check(2, environ, tmp_path)
