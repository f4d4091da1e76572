from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pyros1.robot_nodes.flat_world.sensors import GRAVITY, Imu, Laser, blur_ranges, cast_rays, read_imus
from pyros1.robot_nodes.flat_world.walls import Walls

ROOM = Walls(np.zeros((40, 40), np.bool_), 0.5)
"""20 m x 20 m."""


def march(x: float, y: float, angle: float, discs: np.ndarray, radius: float) -> float:
    """Return where a ray first is in a disc, found by small steps."""
    ways = np.arange(0, 30, 0.002)
    points_x, points_y = x + ways * np.cos(angle), y + ways * np.sin(angle)
    inside = np.any([np.hypot(points_x - dx, points_y - dy) < radius for dx, dy in discs], axis=0)
    return float(ways[inside.argmax()]) if inside.any() else inf


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 0.8))
def test_rays_hit_other_robots(seed: int, radius: float) -> None:
    random = np.random.default_rng(seed)
    poses = np.stack([random.uniform(1, 19, 3), random.uniform(1, 19, 3), random.uniform(-4, 4, 3)], axis=1)
    angles = random.uniform(-pi, pi, 8)
    walls = cast_rays(ROOM, poses, angles, 0.1, 30.0, np.zeros((0, 2)), radius)[0]
    distances, _, are_robots = cast_rays(ROOM, poses, angles, 0.1, 30.0, poses[:, :2], radius)
    for row, heading in enumerate(poses[:, 2]):
        x, y = poses[row, :2] + 0.1 * np.array([np.cos(heading), np.sin(heading)])
        others = np.array([other[:2] for other in poses if np.hypot(other[0] - x, other[1] - y) > radius])
        for column, angle in enumerate(angles):
            robot = march(x, y, heading + angle, others.reshape(-1, 2), radius)
            if abs(robot - walls[row, column]) < 0.01:
                continue
            found = distances[row, column]
            if are_robots[row, column]:  # the steps may miss a ray that only just hits
                assert found == pytest.approx(robot, abs=0.004) or robot == inf
            else:
                assert found == walls[row, column] < robot


def test_the_rays_begin_at_the_laser() -> None:
    pose = np.array([[5.0, 6.0, pi / 2]])
    distances, faces_x, _ = cast_rays(ROOM, pose, np.array([0, pi / 2]), 0.25, 30.0, pose[:, :2], 0.2)
    assert distances.tolist() == [pytest.approx([13.75, 5.0])]
    assert faces_x.tolist() == [[False, True]]


def test_the_rays_of_a_laser() -> None:
    assert Laser(rays=4).angles == pytest.approx([-pi, -pi / 2, 0, pi / 2])


def test_what_a_laser_measures() -> None:
    laser = Laser(max_range=10.0, min_range=0.1, noise=0.5)
    distances = np.array([0.0, 1.0, 9.8, 9.8, inf])
    measured = blur_ranges(distances, laser, np.array([-1.0, 1.0, -1.0, 1.0, 0.0]))
    assert measured == pytest.approx(np.array([0.1, 1.5, 9.3, inf, inf]))
    assert measured.dtype == np.float32


def test_what_an_imu_measures() -> None:
    before, now = np.array([[1.0, 0.0]]), np.array([[1.5, 2.0]])
    exact = Imu(0.0, 0.0, 0.0)
    measured = read_imus(before, now, 0.25, exact, np.array([0.5]), np.random.default_rng(0))
    assert measured.tolist() == [[2.5, 2.0, 3.0, GRAVITY]]
    many = np.zeros((5000, 2))
    noisy = read_imus(many, many, 0.25, Imu(0.1, 0.0, 0.3), np.zeros(5000), np.random.default_rng(0))
    assert noisy.std(axis=0) == pytest.approx([0.1, 0.3, 0.3, 0.3], rel=0.05)
