from __future__ import annotations

import math
import random
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
import yaml

from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.robot_nodes.laser_filters.chain import FILTERS, apply_chain, make_chain
from pyros1.robot_nodes.laser_filters.scans import FilterError
from pyros1.robot_nodes.laser_filters.time_filters import HistoryFilter

from .scan_maker import random_scan

MEDIAN = {"type": "filters/MultiChannelMedianFilterFloat", "params": {"number_of_observations": 3, "unused": 10}}
PARAMETERS: Mapping[str, Mapping[str, Any]] = {
    "LaserArrayFilter": {"range_filter_chain": [MEDIAN], "intensity_filter_chain": [MEDIAN]},
    "LaserMedianFilter": {"internal_filter": MEDIAN},
    "LaserScanAngularBoundsFilter": {"lower_angle": -1, "upper_angle": 1.57},
    "LaserScanAngularBoundsFilterInPlace": {"lower_angle": -1, "upper_angle": 1.57},
    "LaserScanFootprintFilter": {"inscribed_radius": 0.325},
    "LaserScanMaskFilter": {"masks": {"laser": [1, 5], "laser2": []}},
    "LaserScanPolygonFilter": {"polygon_frame": "base_link", "polygon": [[0, 0], [0.1, 0.1], [0.1, 0]]},
    "StaticLaserScanPolygonFilter": {"polygon_frame": "base_link", "polygon": [[0, 0], [0.1, 0.1], [0.1, 0]]},
    "ScanBlobFilter": {"max_radius": 0.25, "min_points": 6},
}
"""Of those that have parameters without a default."""
CHAIN = """
- name: range
  type: laser_filters/LaserScanRangeFilter
  params: {use_message_range_limits: false, lower_threshold: 0.3, upper_threshold: 5, upper_replacement_value: .inf}
- name: mask
  type: LaserScanMaskFilter
  params: {masks: {laser: [2]}}
"""


def make(*specifications: object) -> list[Any]:
    return make_chain(list(specifications), "/node/scan_filter_chain", pytest.fail)


def test_the_filters_are_those_of_the_package() -> None:
    names = """ScanShadowsFilter InterpolationFilter ScanBlobFilter LaserArrayFilter LaserMedianFilter
        LaserScanIntensityFilter LaserScanRangeFilter LaserScanAngularBoundsFilter LaserScanAngularBoundsFilterInPlace
        LaserScanSectorFilter LaserScanBoxFilter LaserScanPolygonFilter StaticLaserScanPolygonFilter
        LaserScanSpeckleFilter LaserScanMaskFilter LaserScanFootprintFilter"""
    assert set(FILTERS) == set(names.split())


@pytest.mark.parametrize("kind", FILTERS)
@pytest.mark.parametrize("size", [0, 1, 60])
def test_all_filters_take_scans_of_any_size(kind: str, size: int) -> None:
    filters = make({"name": "x", "type": f"laser_filters/{kind}", "params": dict(PARAMETERS.get(kind, {}))})
    for seed in range(3):
        scan = random_scan(seed, size=size)
        if kind == "LaserScanSpeckleFilter" and size < 6:
            continue
        before = (list(scan.ranges), list(scan.intensities))
        found = apply_chain(filters, scan, lambda frame: np.eye(4))
        assert type(found) is LaserScan and found.header.frame_id == "laser"
        np.testing.assert_equal((list(scan.ranges), list(scan.intensities)), before)
        assert len(found.ranges) == size or kind == "LaserScanAngularBoundsFilter"


def test_filters_are_applied_one_after_the_other() -> None:
    scan = random_scan(0, size=5)
    scan.ranges = [0.2, 1.0, 2.0, 6.0, 5.0]
    found = apply_chain(make(*yaml.safe_load(CHAIN)), scan, lambda frame: np.eye(4))
    np.testing.assert_array_equal(found.ranges, np.array([math.nan, 1.0, math.nan, math.inf, math.inf], np.float32))


def test_an_empty_chain_changes_nothing() -> None:
    scan = random_scan(0)
    assert apply_chain(make_chain(None, "", pytest.fail), scan, pytest.fail) is scan


@pytest.mark.parametrize(
    ("specification", "problem"),
    [
        (5, r"chain\[1\] must have a type, such as laser_filters/LaserScanRangeFilter"),
        ({"name": "x"}, "must have a type"),
        (
            {"name": "x\ny", "type": "filters/Unknown"},
            r"\[1\] \(x.{1,3}y\): there is no filter filters/Unknown; laser_",
        ),
        ({"type": "other/InterpolationFilter"}, "there is no filter other/InterpolationFilter"),
        ({"type": "laser_filters/ScanShadwosFilter"}, r"ScanShadwosFilter \(did you mean 'ScanShadowsFilter'\?\)"),
        ({"type": "laser_filters/LaserScanAngularBoundsFilter"}, "lower_angle and upper_angle must be set"),
        ({"type": "LaserScanMaskFilter", "params": {"masks": {"laser": [-1]}}}, "masks/laser must be a list of numb"),
        ({"type": "LaserScanMaskFilter"}, "masks must be set"),
        ({"type": "LaserScanFootprintFilter"}, "inscribed_radius must be set"),
        (
            {"type": "LaserScanRangeFilter", "params": [{"lower_threshold": 1}]},
            "params must be a mapping, not .{'lower_",
        ),
        ({"type": "ScanBlobFilter"}, "max_radius and min_points must be set"),
        ({"type": "LaserScanPolygonFilter", "params": {"polygon": "[]"}}, "polygon must be set, to a list of corners"),
        ({"type": "LaserScanPolygonFilter", "params": {"polygon": [[0, 0]] * 3}}, "polygon_frame must be set"),
        ({"type": "LaserScanPolygonFilter", "params": {"polygon": [[0, 0]] * 1001}}, "1001 corners, and 1000 are"),
        ({"type": "LaserArrayFilter"}, "one of range_filter_chain and intensity_filter_chain must be set"),
        ({"type": "LaserArrayFilter", "params": {"range_filter_chain": 5}}, "must be a list of filters"),
        ({"type": "LaserArrayFilter", "params": {"range_filter_chain": [5]}}, "must have a type and params"),
        ({"type": "LaserArrayFilter", "params": {"range_filter_chain": [{"type": "x"}]}}, "may have these types: fil"),
        (
            {"type": "LaserMedianFilter", "params": {"internal_filter": {**MEDIAN, "params": {}}}},
            "number_of_observations in internal_filter must be a number from 1 to 1000",
        ),
    ],
)
def test_mistakes(specification: object, problem: str) -> None:
    with pytest.raises(FilterError, match=problem):
        make({"type": "InterpolationFilter"}, specification)


def test_a_chain_must_be_a_list() -> None:
    with pytest.raises(FilterError, match="/node/chain must be a list of filters"):
        make_chain({"a": 1}, "/node/chain", pytest.fail)


def test_values_of_a_wrong_type_are_reported() -> None:
    reported: list[str] = []
    specification = {"name": "box", "type": "LaserScanBoxFilter", "params": {"min_x": "left", "invert": 1}}
    make_chain([specification], "/node/chain", reported.append)
    assert len(reported) == 2
    assert "/node/chain[0] (box)/min_x must be a number, not 'left': using -1.0" in reported[0]


def test_medians_and_means_over_time() -> None:
    values = [[1, 9], [5, 2], [3, 4], [7, 8]]
    median, mean = HistoryFilter("median", 3), HistoryFilter("mean", 2)
    arrays = [np.array(each, np.float32) for each in values]
    assert [median.add(each).tolist() for each in arrays] == [[1, 9], [1, 2], [3, 4], [5, 4]]
    assert [mean.add(each).tolist() for each in arrays] == [[1, 9], [3, 5.5], [4, 3], [5, 6]]
    assert median.add(np.array([6], np.float32)).tolist() == [6], "another number of rays"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", FILTERS)
def test_scans_with_any_numbers(kind: str) -> None:
    chance = random.Random(kind)
    numbers = [math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-45, 0.0, -1.0, 0.1, 2.0]
    filters = make_chain([{"type": kind, "params": PARAMETERS.get(kind, {})}], "chain", lambda text: None)
    for _ in range(100):
        scan = random_scan(chance.randrange(100))
        for name in ("angle_min", "angle_max", "angle_increment", "time_increment", "range_min", "range_max"):
            if chance.random() < 0.5:
                setattr(scan, name, chance.choice(numbers))
        scan.ranges = [chance.choice(numbers) for _ in scan.ranges]
        with suppress(FilterError):
            filtered = apply_chain(filters, scan, lambda frame: np.eye(4))
            assert len(filtered.ranges) <= len(scan.ranges)
