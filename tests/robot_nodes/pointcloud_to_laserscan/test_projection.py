from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.robot_nodes.pointcloud_to_laserscan.projection import (
    MAX_RAYS,
    ScanSettings,
    project,
    read_settings,
    unproject,
)
from pyros1.robot_nodes.shared.parameters import PrivateParameters


def slow_ranges(points: list[tuple[float, float, float]], settings: ScanSettings) -> list[float]:
    """One point after the other, as the package's documentation says."""
    ranges = [math.inf if settings.use_inf else settings.range_max + settings.inf_epsilon] * settings.num_rays
    for x, y, z in points:
        if any(math.isnan(value) for value in (x, y, z)) or not settings.min_height <= z <= settings.max_height:
            continue
        distance, angle = math.hypot(x, y), math.atan2(y, x)
        if not settings.range_min <= distance <= settings.range_max:
            continue
        if not settings.angle_min <= angle <= settings.angle_max:
            continue
        ray = int((angle - float(np.float32(settings.angle_min))) / float(np.float32(settings.angle_increment)))
        ray = min(max(ray, 0), settings.num_rays - 1)
        ranges[ray] = min(ranges[ray], distance)
    return ranges


@pytest.mark.parametrize("seed", range(40))
def test_any_cloud_in_any_scan(seed: int) -> None:
    chance = random.Random(seed)
    count = chance.choice([0, 1, 5, 400])
    values = [math.nan, math.inf, -math.inf, 0.0]
    points = [
        tuple(chance.choice(values) if chance.random() < 0.03 else chance.uniform(-8, 8) for _ in "xyz")
        for _ in range(count)
    ]
    angle_min = chance.uniform(-math.pi, 2)
    settings = ScanSettings(
        min_height=chance.uniform(-8, 0),
        max_height=chance.uniform(0, 8),
        angle_min=angle_min,
        angle_max=chance.uniform(angle_min + 0.1, math.pi),
        angle_increment=chance.choice([0.005, 0.02, 0.3, 4.0]),
        range_min=chance.uniform(0, 2),
        range_max=chance.uniform(2, 12),
        use_inf=chance.random() < 0.5,
        inf_epsilon=chance.choice([1.0, 0.1]),
    )
    expected = slow_ranges(points, settings)  # type: ignore[arg-type]  # tuples of three
    found = project(np.array(points, np.float64).reshape(-1, 3), settings)
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, np.array(expected, np.float32))


def test_the_defaults_are_those_of_the_package() -> None:
    settings = read_settings(PrivateParameters({}, pytest.fail))
    assert settings == ScanSettings() and settings.num_rays == 360
    above_and_below = np.array([[2.0, 0.1, 0.5], [1.0, 0.1, -0.1]])
    ranges = project(above_and_below, settings)
    assert np.isfinite(ranges).sum() == 1 and np.nanmin(ranges) == pytest.approx(math.hypot(2, 0.1))
    assert np.isinf(project(np.empty((0, 3)), replace(settings, use_inf=False))).all()  # beyond float32


@pytest.mark.parametrize(
    ("values", "expected", "problem"),
    [
        ({"angle_min": 1, "angle_max": 1.0}, (-math.pi, math.pi, math.pi / 180), "more than angle_min, 1, not 1.0"),
        ({"angle_min": 4}, (-math.pi, math.pi, math.pi / 180), "more than angle_min, 4"),
        ({"angle_increment": 0}, (-math.pi, math.pi, math.pi / 180), "of at least 6.28319e-06, not 0"),
        ({"angle_increment": 1e-9}, (-math.pi, math.pi, math.pi / 180), "of at least 6.28319e-06, not 1e-09"),
    ],
)
def test_impossible_angles(values: dict[str, Any], expected: tuple[float, ...], problem: str) -> None:
    problems: list[str] = []
    settings = read_settings(PrivateParameters(values, problems.append))
    assert (settings.angle_min, settings.angle_max, settings.angle_increment) == expected
    assert len(problems) == 1 and problem in problems[0]


@pytest.mark.parametrize("seed", range(10))
def test_a_scan_as_points_and_back(seed: int) -> None:
    chance = random.Random(seed)
    ranges = [chance.choice([math.nan, math.inf, 0.01, 99.0, chance.uniform(0.5, 9)]) for _ in range(90)]
    intensities = [chance.uniform(0, 100) for _ in ranges] if seed % 2 else []
    scan = LaserScan(
        angle_min=-1.0,
        angle_increment=0.02,
        range_min=0.5,
        range_max=9.0,
        ranges=ranges,
        intensities=intensities,
    )
    columns = unproject(scan)
    valid = [number for number, value in enumerate(ranges) if 0.5 <= value < 9.0]
    assert columns["index"].tolist() == valid
    for point, ray in enumerate(valid):
        angle = -1.0 + 0.02 * ray
        assert columns["x"][point] == pytest.approx(ranges[ray] * math.cos(angle), abs=1e-5)
        assert columns["y"][point] == pytest.approx(ranges[ray] * math.sin(angle), abs=1e-5)
    assert list(columns) == ["x", "y", "z", *(["intensity"] if seed % 2 else []), "index"]
    if intensities:
        assert columns["intensity"].tolist() == pytest.approx([intensities[ray] for ray in valid])


@pytest.mark.parametrize(
    "values", [{"angle_min": -1e300}, {"angle_max": 1e300}, {"angle_min": 1.0, "angle_max": 1.0 + 1e-15}]
)
def test_any_angles_give_a_scan(values: dict[str, Any]) -> None:
    settings = read_settings(PrivateParameters(values, lambda text: None))
    assert 1 <= len(project(np.array([[1.0, 1e300, 0.5], [1e300, 1.0, 0.5]]), settings)) <= MAX_RAYS


@pytest.mark.filterwarnings("error")
def test_scans_whose_angles_are_not_finite() -> None:
    scan = LaserScan(angle_increment=math.inf, range_max=9.0, ranges=[1.0, 2.0])
    assert np.isnan(unproject(scan)["x"]).all()
