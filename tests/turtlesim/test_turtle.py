"""How a turtle moves: beside closed formulas, and beside complex numbers on random commands."""

from __future__ import annotations

import cmath
import random
import struct
from math import cos, hypot, pi, sin

import pytest

from pyros1.turtlesim.turtle import PICTURE_SIZE, PIXELS_PER_UNIT, STEP_PERIOD, WORLD_SIZE, Turtle, normalize_angle

NEAR = 1e-9


def test_the_world_is_that_of_stock() -> None:
    assert STEP_PERIOD == 0.016 and struct.pack("f", WORLD_SIZE) == struct.pack(
        "f", (PICTURE_SIZE - 1) / PIXELS_PER_UNIT
    )
    assert f"{WORLD_SIZE / 2:f}" == "5.544445"
    turtle = Turtle()
    assert (turtle.x, turtle.y, turtle.theta) == pytest.approx((5.544445, 5.544445, 0), abs=6e-7)


@pytest.mark.parametrize("speed, turning", [(2.0, 1.8), (1.0, -2.5), (0.5, 0.01), (-1.0, 1.0)])
def test_a_circle_in_closed_form(speed: float, turning: float) -> None:
    """It turns first, then goes: positions are the sums of a geometric series."""
    turtle, steps = Turtle(theta=0.3), 60
    turtle.command(speed, 0.0, turning, now=0.0)
    for _ in range(steps):
        assert turtle.step(now=0.5) is None
    angle = turning * STEP_PERIOD
    ratio = cmath.exp(1j * angle)
    gone = speed * STEP_PERIOD * cmath.exp(0.3j) * ratio * (1 - ratio**steps) / (1 - ratio)
    assert turtle.x == pytest.approx(WORLD_SIZE / 2 + gone.real, abs=NEAR)
    assert turtle.y == pytest.approx(WORLD_SIZE / 2 + gone.imag, abs=NEAR)
    assert turtle.theta == pytest.approx(normalize_angle(0.3 + steps * angle), abs=NEAR)
    # All places are on a circle whose radius is half a step's length over the sine of half a step's angle.
    radius = abs(speed * STEP_PERIOD / 2 / sin(angle / 2))
    centre = complex(WORLD_SIZE / 2, WORLD_SIZE / 2) + speed * STEP_PERIOD * cmath.exp(0.3j) * ratio / (1 - ratio)
    assert abs(complex(turtle.x, turtle.y) - centre) == pytest.approx(radius, abs=1e-7)


@pytest.mark.slow
def test_random_commands() -> None:
    chance = random.Random(7)
    turtle = Turtle()
    position, angle = complex(turtle.x, turtle.y), turtle.theta
    hits = 0
    for second in range(400):
        forward, sideways, turning = (chance.uniform(-3, 3) for _ in range(3))
        turtle.command(forward, sideways, turning, now=float(second))
        for _ in range(chance.randrange(1, 40)):
            requested = turtle.step(now=second + 0.9)
            angle += turning * STEP_PERIOD
            free = position + complex(forward, sideways) * STEP_PERIOD * cmath.exp(1j * angle)
            position = complex(min(max(free.real, 0), WORLD_SIZE), min(max(free.imag, 0), WORLD_SIZE))
            assert (turtle.x, turtle.y) == pytest.approx((position.real, position.imag), abs=1e-6)
            assert cmath.exp(1j * turtle.theta) == pytest.approx(cmath.exp(1j * angle), abs=1e-6)
            assert -pi <= turtle.theta <= pi
            assert (requested is None) == (free == position) or abs(free - position) < NEAR
            hits += requested is not None
        assert turtle.speed == pytest.approx(hypot(forward, sideways))
    assert hits > 100


def test_a_command_holds_for_a_second() -> None:
    turtle = Turtle()
    turtle.command(1.0, 2.0, 3.0, now=10.0)
    turtle.step(now=11.0)
    assert (turtle.forward, turtle.sideways, turtle.turning) == (1.0, 2.0, 3.0)
    before = turtle.position
    turtle.step(now=11.001)
    assert (turtle.speed, turtle.turning, turtle.position) == (0.0, 0.0, before)


def test_walls_and_teleports() -> None:
    turtle = Turtle()
    turtle.command(100.0, 0.0, 0.0, now=0.0)
    assert [turtle.step(now=0.0) for _ in range(3)] == [None] * 3  # of 1.6 units; the wall is at three and a half
    requested = turtle.step(now=0.0)
    assert requested == (pytest.approx(WORLD_SIZE / 2 + 6.4), WORLD_SIZE / 2) and turtle.x == WORLD_SIZE
    turtle.teleport_absolute(-3.0, 99.0, 1.0)
    assert turtle.position == (-3.0, WORLD_SIZE)
    assert turtle.step(now=9.0) == (-3.0, WORLD_SIZE) and turtle.position == (0.0, WORLD_SIZE)
    turtle.teleport_absolute(5.0, 5.0, 1.0)
    turtle.teleport_relative(2.0, 0.5)
    assert (turtle.x, turtle.y, turtle.theta) == pytest.approx((5 + 2 * cos(1.5), 5 + 2 * sin(1.5), 1.5))


@pytest.mark.parametrize("angle", [0.0, 3.0, 3.2, -3.2, 100.0, -1e6, pi, -pi])
def test_normal(angle: float) -> None:
    assert -pi <= normalize_angle(angle) <= pi
    assert cmath.exp(1j * normalize_angle(angle)) == pytest.approx(cmath.exp(1j * angle), abs=1e-8)
