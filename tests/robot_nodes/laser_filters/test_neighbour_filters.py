"""Filters beside slow loops that do what the package's documentation says."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest

from pyros1.robot_nodes.laser_filters.neighbour_filters import (
    BlobFilter,
    InterpolationFilter,
    ShadowsFilter,
    SpeckleFilter,
)
from pyros1.robot_nodes.laser_filters.scans import FilterError

from .scan_maker import random_scan

SEEDS = range(40)


def no_transform(frame: str) -> Any:
    raise AssertionError("these filters need no transform")


def place(value: float, angle: float) -> tuple[float, float]:
    return value * math.cos(angle), value * math.sin(angle)


@pytest.mark.parametrize("seed", SEEDS)
def test_shadows(seed: int) -> None:
    """The angle at each point between its neighbour and the scanner, from their places."""
    chance = random.Random(seed)
    settings = ShadowsFilter(
        math.radians(chance.choice([10, 40])),
        math.radians(chance.choice([170, 120])),
        chance.randrange(3),
        chance.choice([0, 1, 20, 200]),
        chance.random() < 0.5,
    )
    scan = random_scan(seed)
    ranges = np.array(scan.ranges, np.float32).tolist()
    expected = list(ranges)
    for ray, value in enumerate(ranges):
        is_edge = False
        for other in range(max(0, ray - settings.window), min(len(ranges), ray + settings.window + 1)):
            if other == ray or not math.isfinite(value) or not math.isfinite(ranges[other]):
                continue
            x, y = place(ranges[other], (other - ray) * scan.angle_increment)
            angle = math.atan2(abs(y), value - x)  # the scanner is at x = 0, the point at x = value
            is_edge |= angle < settings.min_angle or angle > settings.max_angle
        if value == math.inf and settings.remove_start:
            is_edge = any(
                0 <= other < len(ranges) and other != ray and math.isfinite(ranges[other])
                for other in range(ray - settings.window, ray + settings.window + 1)
            )
        if is_edge:
            for other in range(max(0, ray - settings.neighbours), min(len(ranges), ray + settings.neighbours + 1)):
                if ranges[other] > value:
                    expected[other] = math.nan
            if settings.remove_start:
                expected[ray] = math.nan
    np.testing.assert_array_equal(settings.apply(scan, no_transform).ranges, np.array(expected, np.float32))


@pytest.mark.parametrize("seed", SEEDS)
def test_speckles(seed: int) -> None:
    chance = random.Random(seed)
    settings = SpeckleFilter(3.0, chance.choice([0.1, 0.5]), chance.choice([1, 2, 5]), by_radius=seed % 2 == 1)
    scan = random_scan(seed)
    ranges = np.array(scan.ranges, np.float32).astype(float).tolist()
    if len(ranges) <= settings.window + 1:
        with pytest.raises(FilterError, match="too small for the filter_window"):
            settings.apply(scan, no_transform)
        return
    kept = {ray for ray, value in enumerate(ranges) if value > 3.0}
    for ray in range(len(ranges) - settings.window + 1):
        if settings.by_radius:
            others = range(max(0, ray - settings.window), min(len(ranges), ray + settings.window + 1))
            places = {other: place(ranges[other], other * scan.angle_increment) for other in others}
            near = sum(
                math.isfinite(ranges[other] + ranges[ray])
                and math.dist(places[ray], places[other]) <= settings.max_difference
                for other in others
                if other != ray
            )
            good = near >= settings.window
        else:
            part = ranges[ray : ray + settings.window]
            equal = all(value == part[0] or abs(value - part[0]) <= settings.max_difference for value in part)
            good = equal and not math.isnan(part[0])
        kept |= set(range(ray, ray + settings.window)) if good else set()
    expected = [value if ray in kept else math.nan for ray, value in enumerate(ranges)]
    np.testing.assert_array_equal(settings.apply(scan, no_transform).ranges, np.array(expected, np.float32))


@pytest.mark.parametrize("seed", SEEDS)
def test_interpolation(seed: int) -> None:
    scan = random_scan(seed)
    expected = []
    for ray, value in enumerate(scan.ranges):
        if not (value <= scan.range_min or value >= scan.range_max):
            expected.append(value)
            continue
        sides = []
        for step in (-1, 1):
            other = ray
            while 0 <= other < len(scan.ranges) and (
                scan.ranges[other] <= scan.range_min or scan.ranges[other] >= scan.range_max
            ):
                other += step
            sides.append(scan.ranges[other] if 0 <= other < len(scan.ranges) else scan.range_max - 0.01)
        expected.append(sum(sides) / 2)
    found = InterpolationFilter().apply(scan, no_transform)
    np.testing.assert_allclose(found.ranges, np.array(expected, np.float32), rtol=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_blobs(seed: int) -> None:
    scan = random_scan(seed)
    ranges = np.array(scan.ranges, np.float32).astype(float).tolist()
    expected = [-abs(value) for value in ranges]
    blob: list[int] = []
    for ray in range(len(ranges) + 1):
        if ray < len(ranges) and ranges[ray] >= 0:
            blob.append(ray)
            continue
        values = [ranges[each] for each in blob]
        if len(blob) > 3 and max(abs(value - sum(values) / len(values)) for value in values) < 0.2:
            expected[blob[len(blob) // 2]] = ranges[blob[len(blob) // 2]]
        blob = []
    np.testing.assert_array_equal(BlobFilter(0.2, 3).apply(scan, no_transform).ranges, np.array(expected, np.float32))
