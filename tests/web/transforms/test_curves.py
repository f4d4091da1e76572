"""Curves of a plot."""

from __future__ import annotations

import math
from typing import Any

import pytest

from pyros1 import Duration, Time
from pyros1.msgs.geometry_msgs.msg import PointStamped
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.msgs.std_msgs.msg import Bool, Float64, String
from pyros1.msgs.std_msgs.msg import Duration as DurationMessage
from pyros1.web.transforms.curves import MAX_POINTS, Curve, CurveError


def find(name: str) -> tuple[str, str, str] | None:
    topic = "/" + name.split("/")[1]
    return (topic, "any", name[len(topic) :]) if topic == "/topic" else None


def points(text: str, *messages: Any, stamped: bool = False) -> dict[int, tuple[list[float], list[float]]]:
    curve = Curve(text, stamped)
    assert curve.find(find) == "/topic"
    for number, message in enumerate(messages):
        curve.add(message, float(number))
    assert not curve.problem
    return curve.take(1000)


def test_a_field() -> None:
    assert points("/topic/point/x", *(PointStamped() for _ in range(2))) == {-1: ([0.0, 1.0], [0.0, 0.0])}
    assert points("/topic/data", Bool(True)) == {-1: ([0.0], [1.0])}
    assert points("/topic/data", DurationMessage(Duration(2, 500_000_000))) == {-1: ([0.0], [2.5])}


def test_elements_of_arrays() -> None:
    state = JointState(position=[1.0, 2.0, 3.0])
    assert points("/topic/position[2]", state) == {-1: ([0.0], [3.0])}
    assert points("/topic/position[1:]", state) == {0: ([0.0], [2.0]), 1: ([0.0], [3.0])}
    assert points("/topic/position", state, JointState(position=[5.0])) == {
        0: ([0.0, 1.0], [1.0, 5.0]),
        1: ([0.0], [2.0]),
        2: ([0.0], [3.0]),
    }


def test_an_expression() -> None:
    message = PointStamped()
    message.point.x, message.point.y = 3.0, 4.0
    assert points("/topic: hypot(m.point.x, m.point.y) * 2", message) == {-1: ([0.0], [10.0])}


def test_a_message_with_one_number_is_that_number() -> None:
    assert points("/topic", Float64(2.5)) == {-1: ([0.0], [2.5])}


def test_the_time_of_the_header() -> None:
    message = PointStamped()
    message.header.stamp = Time(12, 500_000_000)
    assert points("/topic/point/z", message, stamped=True) == {-1: ([12.5], [0.0])}


@pytest.mark.parametrize(
    "text", ["velocity/data", "", "/topic: m.data +", "/topic: __import__('os')", "/topic: (lambda: 1)()"]
)
def test_a_malformed_text_is_refused(text: str) -> None:
    with pytest.raises(CurveError):
        Curve(text)


@pytest.mark.parametrize(
    ("text", "message", "problem"),
    [
        ("/topic/data", String("x"), "not a number, but a string"),
        ("/topic/point", PointStamped(), "choose one of its fields"),
        ("/topic/nothing", PointStamped(), "type geometry_msgs/PointStamped has no field 'nothing'"),
        ("/topic/point/bad/x", PointStamped(), "type geometry_msgs/Point has no field 'bad'"),
        (
            "/topic/position[7]",
            JointState(position=[1.0]),
            "the last message has no such element, index out of range: /position[7]",
        ),
        ("/topic/position[3]", JointState(), "index out of range"),
        ("/topic/position", JointState(position=[0.0] * 51), "an array of 51 elements"),
        ("/topic: m.point.x / 0", PointStamped(), "division by zero"),
    ],
)
def test_what_cannot_be_drawn_is_said_and_the_next_message_counts(text: str, message: Any, problem: str) -> None:
    curve = Curve(text)
    curve.find(find)
    curve.add(message, 0.0)
    assert problem in curve.problem
    assert curve.take(10) == {}


def test_a_problem_ends_with_the_next_good_message() -> None:
    curve = Curve("/topic/position[0]")
    curve.find(find)
    curve.add(JointState(), 0.0)
    assert curve.problem
    curve.add(JointState(position=[4.0]), 1.0)
    assert not curve.problem
    assert curve.take(10) == {-1: ([1.0], [4.0])}
    assert curve.take(10) == {}


def test_a_topic_that_is_not_there_yet() -> None:
    assert Curve("/other/data").find(find) is None
    assert Curve("/other: m.data").find(find) is None


def test_points_that_nobody_takes_are_bounded_and_keep_spikes() -> None:
    curve = Curve("/topic/position[0]")
    curve.find(find)
    state = JointState(position=[0.0])
    for number in range(3 * MAX_POINTS):
        state.position = [1e9 if number == 777 else math.sin(number)]
        curve.add(state, float(number))
    ((times, values),) = curve.take(10**9).values()
    assert len(times) <= MAX_POINTS + 1
    assert max(values) == 1e9
    assert times == sorted(times)
