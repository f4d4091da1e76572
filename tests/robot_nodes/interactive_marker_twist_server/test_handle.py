"""How far the marker is dragged, and how fast that is."""

from __future__ import annotations

import random
from math import cos, pi, sin
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import Point, Pose, Quaternion
from pyros1.robot_nodes.interactive_marker_twist_server.handle import Settings, make_marker, read_settings, twist_for
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.twists import components


def settings(**values: Any) -> Settings:
    return read_settings(PrivateParameters(values, pytest.fail))


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> Any:
    return Pose(Point(x, y, z), Quaternion(0.0, 0.0, sin(yaw / 2), cos(yaw / 2)))


@pytest.mark.parametrize(
    ("values", "dragged", "expected"),
    [
        ({}, pose(0.5, 0.7, 0.8), (0.5, 0, 0, 0, 0, 0)),
        ({}, pose(5.0), (1, 0, 0, 0, 0, 0)),
        ({}, pose(-5.0), (-1, 0, 0, 0, 0, 0)),
        ({"linear_scale": 2, "max_positive_linear_velocity": 0.3}, pose(0.2), (0.3, 0, 0, 0, 0, 0)),
        ({"max_negative_linear_velocity": -0.1}, pose(-0.2), (-0.1, 0, 0, 0, 0, 0)),
        ({}, pose(yaw=0.5), (0, 0, 0, 0, 0, 1.1)),
        ({}, pose(yaw=-3.0), (0, 0, 0, 0, 0, -2.2)),
        ({"angular_scale": 1, "max_angular_velocity": 0.4}, pose(yaw=0.5), (0, 0, 0, 0, 0, 0.4)),
        (
            {
                "linear_scale": {"x": 1, "z": 2.0},
                "max_positive_linear_velocity": {"x": 1, "z": 9},
                "max_negative_linear_velocity": {"x": 0.0},
            },
            pose(-0.5, 0.5, 0.5),
            (0, 0, 1.0, 0, 0, 0),
        ),
        ({"linear_scale": {"x": 1}}, pose(0.5), (0, 0, 0, 0, 0, 0)),
    ],
)
def test_commands(values: dict[str, Any], dragged: Any, expected: tuple[float, ...]) -> None:
    assert components(twist_for(dragged, settings(**values))) == pytest.approx(expected)


def test_the_robot_is_never_too_fast() -> None:
    chance = random.Random(8)
    for _ in range(500):
        limit = chance.uniform(0, 3)
        found = settings(max_positive_linear_velocity=limit, max_angular_velocity=limit, linear_scale=9)
        turn = Quaternion(*(chance.uniform(-2, 2) for _ in range(4)))
        twist = twist_for(Pose(Point(chance.uniform(-9, 9), 0.0, 0.0), turn), found)
        assert -1 <= twist.linear.x <= limit and abs(twist.angular.z) <= min(limit, 2.2 * pi)


def test_marker() -> None:
    marker = make_marker(settings(linear_scale={"x": 1, "y": 1, "z": 1}, link_name="base", robot_name="husky"))
    assert (marker.header.frame_id, marker.name, marker.scale) == ("base", "husky_twist_marker", 1.0)
    half = pytest.approx(0.5**0.5)
    turns = {each.name: each.orientation for each in marker.controls}
    assert {name: (turn.x, turn.y, turn.z, turn.w) for name, turn in turns.items()} == {
        "move_x": (half, 0, 0, half),
        "move_y": (0, 0, half, half),
        "move_z": (0, half, 0, half),
        "rotate_z": (0, half, 0, half),
    }
    assert [control.interaction_mode for control in marker.controls] == [3, 3, 3, 5]
    assert [control.name for control in make_marker(settings()).controls] == ["move_x", "rotate_z"]


def test_parameters_that_cannot_be_used() -> None:
    problems: list[str] = []
    values = {"linear_scale": {"x": "far", "w": 1}, "max_angular_velocity": -1}
    read_settings(PrivateParameters(values, problems.append))
    assert ["/w must be for x, y or z" in problems[0], "/x must be" in problems[1], len(problems)] == [True, True, 3]


@pytest.mark.parametrize("factor", [1e-200, 0.1, 7.0, 1e200])
def test_rotations_of_any_length(factor: float) -> None:
    turned = pose(yaw=0.5)
    turned.orientation.z, turned.orientation.w = turned.orientation.z * factor, turned.orientation.w * factor
    assert twist_for(turned, settings()).angular.z == pytest.approx(1.1)


def test_no_rotation_is_none() -> None:
    assert twist_for(Pose(Point(), Quaternion()), settings()).angular.z == 0.0
