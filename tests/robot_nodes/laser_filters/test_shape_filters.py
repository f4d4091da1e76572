from __future__ import annotations

import math
import random

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.robot_nodes.laser_filters.scans import Matrix
from pyros1.robot_nodes.laser_filters.shape_filters import BoxFilter, FootprintFilter, PolygonFilter, ShapeFilter
from pyros1.tf.transformations import euler_matrix

from .scan_maker import random_scan

SEEDS = range(20)
Point = tuple[float, float, float]


def matrix(seed: int) -> Matrix:
    chance = random.Random(seed)
    found = np.array(euler_matrix(chance.uniform(-1, 1), chance.uniform(-1, 1), chance.uniform(-1, 1)))
    found[:3, 3] = [chance.uniform(-1, 1) for _ in range(3)]
    return found


def check(shape: ShapeFilter, scan: LaserScan, to_frame: Matrix, inside: object, invert: bool) -> None:
    """Compare with one point after the other; `inside` tells for a point whether it is inside."""
    found = shape.apply(scan, {shape.frame: to_frame}.__getitem__)
    for ray, value in enumerate(scan.ranges):
        expected = value
        if scan.range_min <= value < scan.range_max:
            angle = scan.angle_min + ray * scan.angle_increment
            x, y, z, _ = to_frame @ [value * math.cos(angle), value * math.sin(angle), 0.0, 1.0]
            if inside((x, y, z)) != invert:  # type: ignore[operator]  # a function
                expected = math.nan
        assert found.ranges[ray] == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize("seed", SEEDS)
def test_box(seed: int) -> None:
    corner, opposite, invert = (-2.0, -1.0, -0.5), (3.0, 4.0, 0.9), seed % 2 == 1

    def inside(point: Point) -> bool:
        return all(low < value < high for low, value, high in zip(corner, point, opposite, strict=True))

    check(BoxFilter("base_link", corner, opposite, invert), random_scan(seed), matrix(seed), inside, invert)


@pytest.mark.parametrize("seed", SEEDS)
def test_footprint(seed: int) -> None:
    def inside(point: Point) -> bool:
        return max(abs(point[0]), abs(point[1])) <= 1.7

    check(FootprintFilter(1.7), random_scan(seed), matrix(seed), inside, False)


@pytest.mark.parametrize("seed", SEEDS)
def test_polygon(seed: int) -> None:
    """A point is inside if the corners go around it: their angles, seen from there, add up to a full turn."""
    chance = random.Random(seed)
    angles = sorted(chance.uniform(0, 2 * math.pi) for _ in range(7))
    star = [(math.cos(angle) * chance.uniform(1, 5), math.sin(angle) * chance.uniform(1, 5)) for angle in angles]
    padding, invert = chance.choice([0.0, 0.5]), chance.random() < 0.5
    corners = [tuple(value + math.copysign(padding, value) for value in corner) for corner in star]

    def inside(point: Point) -> bool:
        turn = 0.0
        seen = [math.atan2(y - point[1], x - point[0]) for x, y in corners]
        for one, other in zip(seen, [*seen[1:], seen[0]], strict=True):
            turn += math.remainder(other - one, 2 * math.pi)
        return round(turn / (2 * math.pi)) % 2 == 1

    check(PolygonFilter("map", np.array(star), padding, invert), random_scan(seed), matrix(seed), inside, invert)


def test_edges() -> None:
    """The edge belongs to a footprint, but not to a box."""
    corner = np.array([[1.5, -1.5, 0.0]])
    assert FootprintFilter(1.5).contains(corner).all()
    assert not BoxFilter("", (-1.5, -1.5, -1.0), (1.5, 1.5, 1.0)).contains(corner).any()


def test_no_transform_is_needed_in_the_frame_of_the_scan() -> None:
    scan = random_scan(3, size=60)
    found = BoxFilter("laser", (-9, -9, -9), (9, 9, 9)).apply(scan, pytest.fail)
    assert all(math.isnan(found.ranges[ray]) for ray, value in enumerate(scan.ranges) if 0.1 <= value < 8.0)
