"""Filters beside slow loops that do what the package's documentation says."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.robot_nodes.laser_filters.value_filters import (
    AngularBoundsFilter,
    AngularBoundsFilterInPlace,
    IntensityFilter,
    MaskFilter,
    RangeFilter,
    SectorFilter,
)

from .scan_maker import random_scan

SEEDS = range(30)


def no_transform(frame: str) -> Any:
    raise AssertionError("these filters need no transform")


def same(found: LaserScan, scan: LaserScan, ranges: Any, intensities: Any = None) -> None:
    """Check a filtered scan, and that the other fields have not changed."""
    np.testing.assert_array_equal(np.asarray(found.ranges, np.float32), np.array(ranges, np.float32))
    expected = scan.intensities if intensities is None else intensities
    np.testing.assert_allclose(np.asarray(found.intensities), np.array(expected, np.float32))
    for name in ("header", "angle_min", "angle_increment", "time_increment", "scan_time", "range_min", "range_max"):
        assert getattr(found, name) == getattr(scan, name)


@pytest.mark.parametrize("seed", SEEDS)
def test_range(seed: int) -> None:
    chance = random.Random(seed)
    low, high = chance.choice([0.0, 2.0]), chance.choice([3.0, 5.0, 1.0])
    new_low, new_high = chance.choice([math.nan, -math.inf, 0.3]), chance.choice([math.nan, math.inf, 4.99])
    use_limits = chance.random() < 0.3
    scan = random_scan(seed)
    expected = []
    for value in scan.ranges:
        lower, upper = (scan.range_min, scan.range_max) if use_limits else (low, high)
        expected.append(new_low if value <= lower else new_high if value >= upper else value)
    same(RangeFilter(use_limits, low, high, new_low, new_high).apply(scan, no_transform), scan, expected)


@pytest.mark.parametrize("seed", SEEDS)
def test_intensity(seed: int) -> None:
    chance = random.Random(seed)
    flags = [chance.random() < 0.5 for _ in range(3)]
    scan = random_scan(seed)
    found = IntensityFilter(5000.0, 15000.0, *flags).apply(scan, no_transform)
    ranges, intensities = list(scan.ranges), list(scan.intensities)
    for ray, intensity in enumerate(scan.intensities):
        removed = (intensity <= 5000 or intensity >= 15000) != flags[0]
        if removed and flags[1]:
            ranges[ray] = math.nan
        if flags[2]:
            intensities[ray] = 0.0 if removed else 1.0
    same(found, scan, ranges, intensities)


@pytest.mark.parametrize("seed", SEEDS)
def test_angular_bounds(seed: int) -> None:
    chance = random.Random(seed)
    scan = random_scan(seed, nan=False, size=60)
    first, last = sorted([scan.angle_min, scan.angle_max])
    lower, upper = sorted(chance.uniform(first - 0.3, last + 0.3) for _ in range(2))
    angles = [scan.angle_min + ray * scan.angle_increment for ray in range(60)]
    expected = [ray for ray, angle in enumerate(angles) if lower <= angle <= upper]
    found = AngularBoundsFilter(lower, upper).apply(scan, no_transform)
    if not expected:  # it may keep the next ray
        assert len(found.ranges) <= 1
        return
    assert found.ranges.tolist() == pytest.approx([scan.ranges[ray] for ray in expected])
    assert found.angle_min == pytest.approx(angles[expected[0]])
    assert found.angle_max == pytest.approx(angles[expected[-1]])
    assert found.header.stamp.to_sec() == pytest.approx(0.001 * expected[0]) and found.header.frame_id == "laser"
    assert list(found.intensities) == pytest.approx([scan.intensities[ray] for ray in expected if scan.intensities])


@pytest.mark.parametrize("seed", SEEDS)
def test_angular_bounds_in_place(seed: int) -> None:
    scan = random_scan(seed)
    found = AngularBoundsFilterInPlace(-0.5, 0.7).apply(scan, no_transform)
    ranges, intensities = list(scan.ranges), list(scan.intensities)
    for ray in range(len(ranges)):
        if -0.5 < scan.angle_min + ray * scan.angle_increment < 0.7:
            ranges[ray] = 9.0
            intensities[ray : ray + 1] = [0.0] if intensities else []
    same(found, scan, ranges, intensities)


@pytest.mark.parametrize("seed", SEEDS)
def test_sector(seed: int) -> None:
    """The sector is written as a test of directions, so that it holds for those beyond pi, too."""
    chance = random.Random(seed)
    begin, end = chance.uniform(-3, 3), chance.uniform(-3, 3)
    clear_inside = chance.random() < 0.5
    scan = random_scan(seed)
    scan.angle_increment = math.copysign(0.01, scan.angle_increment)  # to directions from -pi to pi
    found = SectorFilter(begin, end, 1.0, 3.0, clear_inside).apply(scan, no_transform)
    ranges, intensities = list(scan.ranges), list(scan.intensities)
    for ray, value in enumerate(scan.ranges):
        angle = scan.angle_min + ray * scan.angle_increment
        within = begin < angle < end if begin <= end else angle > begin or angle < end
        if (within and 1.0 < value < 3.0) == clear_inside:
            ranges[ray] = 9.0
            intensities[ray : ray + 1] = [0.0] if intensities else []
    same(found, scan, ranges, intensities)


def test_mask() -> None:
    scan = random_scan(1, nan=False, size=9)
    masks = MaskFilter({"laser": (0, 4, 8, 9, 1000), "other": (1,)})
    found = masks.apply(scan, no_transform)
    assert [ray for ray, value in enumerate(found.ranges) if math.isnan(value)] == [0, 4, 8]
    scan.header.frame_id = "unknown"
    assert masks.apply(scan, no_transform) == scan
