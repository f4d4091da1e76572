"""The square that a turtle draws, with the turtle itself and no node."""

from __future__ import annotations

from math import pi

import pytest

from pyros1.turtlesim.square import SIDE_LENGTH, Square
from pyros1.turtlesim.turtle import STEP_PERIOD, Turtle, normalize_angle


def test_four_sides_lead_back() -> None:
    turtle = Turtle()
    square = Square(turtle.x, turtle.y, turtle.theta)
    start, goals = turtle.position, [square.goal]
    for index in range(10_000):
        moving = turtle.speed > 0 or turtle.turning != 0
        speed, turning = square.next_speeds(turtle.x, turtle.y, turtle.theta, moving)
        assert not (speed and turning)
        if square.goal != goals[-1]:
            goals.append(square.goal)
        if len(goals) == 9:
            break
        turtle.command(speed, 0.0, turning, now=index * STEP_PERIOD)
        turtle.step(now=index * STEP_PERIOD)
    corners = [position for position, _ in goals[::2]]
    assert corners[0] == (pytest.approx(start.x + SIDE_LENGTH), start.y)
    assert [
        normalize_angle(theta - index * pi / 2) for index, (_, theta) in enumerate(goals[1::2], 1)
    ] == pytest.approx([0] * 4, abs=0.1)
    assert turtle.position == pytest.approx(start, abs=0.2)
