from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.flat_world.drive import Drive, move

POSES = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-3, 3)).map(lambda pose: np.array([pose]))
NO_SLIP = Drive(slip=0.0, noise=0.0)


def assert_same(pose: np.ndarray, expected: np.ndarray) -> None:
    assert pose[0, :2] == pytest.approx(expected[0, :2], abs=1e-6)
    assert np.exp(1j * pose[0, 2]) == pytest.approx(np.exp(1j * expected[0, 2]), abs=1e-6)


@given(POSES, st.floats(-5, 5), st.floats(0.05, 3), st.sampled_from([-1, 1]))
def test_an_arc_is_part_of_a_circle(pose: np.ndarray, radius: float, turn: float, side: int) -> None:
    """The centre of the circle is at the left of the robot, at a distance of the radius, and stays there."""
    moved = move(pose, np.array([[radius * side * turn, side * turn]]))

    def centre(of: np.ndarray) -> list[float]:
        x, y, heading = of[0]
        return [x - radius * np.sin(heading), y + radius * np.cos(heading)]

    assert centre(moved) == pytest.approx(centre(pose), abs=1e-6)
    assert np.exp(1j * moved[0, 2]) == pytest.approx(np.exp(1j * (pose[0, 2] + side * turn)))
    assert -pi <= moved[0, 2] <= pi


@given(POSES, st.floats(-5, 5), st.floats(-3, 3))
def test_many_small_steps_are_one_large_one(pose: np.ndarray, length: float, turn: float) -> None:
    stepped = pose
    for _ in range(7):
        stepped = move(stepped, np.array([[length / 7, turn / 7]]))
    assert_same(stepped, move(pose, np.array([[length, turn]])))
    assert_same(move(stepped, -np.array([[length, turn]])), pose)


@given(POSES, st.floats(-5, 5), st.sampled_from([0.0, 1e-300, -1e-12]))
def test_straight_ahead(pose: np.ndarray, length: float, turn: float) -> None:
    x, y, heading = pose[0]
    expected = [x + length * np.cos(heading), y + length * np.sin(heading)]
    assert move(pose, np.array([[length, turn]]))[0, :2] == pytest.approx(expected, abs=1e-9)


@given(st.floats(-1, 1), st.floats(-3, 3))
def test_wheels(speed: float, turn: float) -> None:
    speeds = np.array([[speed, turn]])
    wheels = NO_SLIP.to_wheels(speeds)
    assert wheels[0] == pytest.approx([speed - turn * 0.145, speed + turn * 0.145])
    assert NO_SLIP.from_wheels(wheels)[0] == pytest.approx([speed, turn])
    assert np.array_equal(NO_SLIP.slipped(wheels, np.zeros((1, 2)), np.random.default_rng(0)), wheels)


def test_speeding_up() -> None:
    drive = Drive(max_speed=1.0, max_turn=3.0, acceleration=2.0, turn_acceleration=6.0)
    speeds = np.zeros((2, 2))
    wanted = np.array([[9.0, -0.2], [-0.1, -9.0]])
    speeds = drive.speed_up(speeds, wanted, 0.1)
    assert speeds == pytest.approx(np.array([[0.2, -0.2], [-0.1, -0.6]]))
    for _ in range(20):
        speeds = drive.speed_up(speeds, wanted, 0.1)
    assert speeds == pytest.approx(np.array([[1.0, -0.2], [-0.1, -3.0]]))


def test_slip_and_noise_have_the_size_that_was_asked_for() -> None:
    drive = Drive(slip=0.02, noise=0.005)
    random = np.random.default_rng(1)
    slips = drive.draw_slips(10_000, random)
    assert slips.min() >= 0 and slips.max() <= 0.04
    assert slips.mean() == pytest.approx(0.02, rel=0.02)
    ways = np.full((10_000, 2), 0.04)
    moved = drive.slipped(ways, np.zeros_like(ways), random)
    assert moved.mean() == pytest.approx(0.04, rel=0.01)
    assert moved.std() == pytest.approx(0.005 * 0.2, rel=0.03)  # 25 steps of 0.04 m have the noise of 1 m
    assert drive.slipped(ways, np.full_like(ways, 0.5), random).mean() == pytest.approx(0.02, rel=0.01)
