"""From buttons and axes to twists."""

from __future__ import annotations

import random
from math import nan
from typing import Any

import pytest

from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.twists import components
from pyros1.robot_nodes.teleop_twist_joy.teleop import Teleop, read_controls

SIX = {"axis_linear": {"x": 0, "y": 1, "z": 2}, "scale_linear": {"x": 1, "y": 2.0, "z": 3}}
SIX |= {"scale_linear_turbo": {"x": 10, "y": 20}, "axis_angular": {"roll": 3, "pitch": 4, "yaw": 5}}
SIX |= {"scale_angular": {"roll": 4, "pitch": 5, "yaw": 6}, "scale_angular_turbo": {"yaw": 60}}


def teleop(**values: Any) -> Teleop:
    return Teleop(read_controls(PrivateParameters(values, pytest.fail)))


def drive(machine: Teleop, axes: list[float], buttons: list[int]) -> tuple[float, ...] | None:
    twist = machine.handle(axes, buttons)
    return None if twist is None else tuple(components(twist))


@pytest.mark.parametrize(
    ("values", "axes", "buttons", "expected"),
    [
        ({}, [0.5, 1.0], [1], (0.5, 0, 0, 0, 0, 0.25)),
        ({"enable_turbo_button": 1}, [0.5, 1.0], [0, 1], (1.0, 0, 0, 0, 0, 0.25)),
        ({"enable_turbo_button": 1, "scale_angular": 2}, [0.5, 1.0], [1, 1], (1.0, 0, 0, 0, 0, 1.0)),
        ({"enable_turbo_button": 1, "scale_angular_turbo": 3}, [0.5, 1.0], [1, 1], (1.0, 0, 0, 0, 0, 1.5)),
        ({"axis_linear": 3, "axis_angular": 2, "scale_linear": -1}, [0, 0, 1.0, 1.0], [1], (-1, 0, 0, 0, 0, 0.5)),
        ({"axis_linear": 3, "axis_angular": -1}, [1.0, 1.0], [1], (0, 0, 0, 0, 0, 0)),
        ({"enable_button": -1}, [0.0, 1.0], [], (0.5, 0, 0, 0, 0, 0)),
        (SIX, [1.0] * 6, [1], (1, 2, 3, 4, 5, 6)),
        (SIX | {"enable_turbo_button": 2}, [1.0] * 6, [0, 0, 1], (10, 20, 0, 0, 0, 60)),
        (SIX | {"scale_linear": {}}, [1.0] * 6, [1], (0, 0, 0, 4, 5, 6)),
        ({}, [nan, 1.0], [1], (0.5, 0, 0, 0, 0, 0)),
        ({"scale_linear": 1e300}, [0.5, 1e38], [1], (0, 0, 0, 0, 0, 0.25)),
    ],
)
def test_commands(values: dict[str, Any], axes: list[float], buttons: list[int], expected: tuple[float, ...]) -> None:
    assert drive(teleop(**values), axes, buttons) == expected


def test_one_stop_when_the_button_is_released() -> None:
    machine = teleop()
    moving, still = (0.5, 0, 0, 0, 0, 0), (0,) * 6
    presses = [[0], [0], [1], [1], [], [0], [1], [0], [0]]
    expected = [still, None, moving, moving, still, None, moving, still, None]
    assert [drive(machine, [0.0, 1.0], buttons) for buttons in presses] == expected


def test_it_never_drives_unless_a_button_is_pressed() -> None:
    chance = random.Random(4)
    for _ in range(300):
        enable, turbo = chance.randrange(6), chance.randrange(-2, 6)
        machine = teleop(enable_button=enable, enable_turbo_button=turbo)
        moved = False
        for _ in range(10):
            axes = [chance.uniform(-1, 1) for _ in range(chance.randrange(4))]
            buttons = [chance.randrange(2) for _ in range(chance.randrange(6))]
            pressed = {number for number, value in enumerate(buttons) if value}
            twist = drive(machine, axes, buttons)
            if not pressed & {enable, turbo}:
                assert twist == (0,) * 6 or (twist is None and not moved)
            else:
                assert twist is not None
            moved = twist is not None and any(twist)


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"axis_linear": "x"}, "axis_linear must be an integer"),
        ({"axis_linear": {"x": 1, "w": 2}}, "axis_linear/w must be the number of an axis for x, y, z"),
        ({"axis_angular": {"yaw": "left"}}, "axis_angular/yaw must be the number of an axis"),
        ({"axis_linear": {"x": 1}, "scale_linear": 0.5}, "scale_linear must be a mapping, as the axes are"),
        ({"axis_linear": {"x": 1}, "scale_linear": {"x": nan}}, "scale_linear/x must be a number"),
        ({"scale_linear": {"x": 1}}, "scale_linear must be a number"),
    ],
)
def test_parameters_that_cannot_be_used(values: dict[str, Any], problem: str) -> None:
    problems: list[str] = []
    Teleop(read_controls(PrivateParameters(values, problems.append))).handle([1.0] * 6, [1])
    assert len(problems) == 1 and problem in problems[0]
