"""Messages as shapes."""

from __future__ import annotations

import json
import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.geometry_msgs.msg import (
    Point,
    Point32,
    Polygon,
    PolygonStamped,
    PoseStamped,
    PoseWithCovarianceStamped,
    WrenchStamped,
)
from pyros1.msgs.nav_msgs.msg import GridCells, OccupancyGrid, Path
from pyros1.msgs.sensor_msgs.msg import JointState, LaserScan, Range, Temperature
from pyros1.web.scene import shapes
from pyros1.web.scene.shapes import SHAPE_FUNCTIONS, ShapeError


def test_a_scan_with_holes() -> None:
    facts, blob = shapes.laser_scan(LaserScan(angle_min=-1.0, angle_increment=0.5, ranges=[1.0, float("inf")]))
    assert (facts["count"], facts["intensities"]) == (2, False)
    assert struct.unpack("<2f", blob) == (1.0, float("inf"))
    facts, blob = shapes.laser_scan(LaserScan(ranges=[1.0, 2.0], intensities=[3.0, 4.0]))
    assert struct.unpack("<4f", blob) == (1.0, 2.0, 3.0, 4.0)
    for intensities, expected in ([3.0], (3.0, 0.0)), ([3.0, 4.0, 5.0], (3.0, 4.0)):
        _, blob = shapes.laser_scan(LaserScan(ranges=[1.0, 2.0], intensities=intensities))
        assert struct.unpack("<2f", blob[8:]) == expected


@pytest.mark.parametrize("name", ["angle_min", "angle_increment", "range_min", "range_max"])
def test_scans_without_bounds(name: str) -> None:
    with pytest.raises(ShapeError, match=f"{name} is nan"):
        shapes.laser_scan(LaserScan(ranges=[1.0], **{name: math.nan}))


def test_rangers_of_one_distance_say_with_infinity_whether_something_is_there() -> None:
    there = Range(min_range=2.0, max_range=2.0, range=-math.inf)
    facts, _ = shapes.range_(there)
    assert (facts["inside"], facts["range"]) == (True, 2.0)
    for message in Range(min_range=2.0, max_range=2.0, range=math.inf), Range(max_range=2.0, range=-math.inf):
        assert not shapes.range_(message)[0]["inside"]


def test_maps() -> None:
    message = OccupancyGrid(data=[-1, 0, 100, 50, 0, 0])
    message.info.width, message.info.height, message.info.resolution = 3, 2, 0.05
    facts, blob = shapes.occupancy_grid(message)
    assert (facts["width"], facts["height"]) == (3, 2)
    assert struct.unpack("<6b", blob) == (-1, 0, 100, 50, 0, 0)


@pytest.mark.parametrize(("width", "cells"), [(1, b"\xff\0"), (4, b"\xff\0\x64\x32\0\0\xff\xff")])
def test_of_maps_with_other_numbers_of_cells_what_is_there_is_drawn(width: int, cells: bytes) -> None:
    message = OccupancyGrid(data=[-1, 0, 100, 50, 0, 0])
    message.info.width, message.info.height, message.info.resolution = width, 2, 0.05
    facts, blob = shapes.occupancy_grid(message)
    assert (facts["odd"], blob) == (f"a map of {width} x 2 cells has 6 values", cells)


def test_maps_that_cannot_be_drawn() -> None:
    message = OccupancyGrid(data=[0])
    message.info.width, message.info.height = 1, 1
    for number in (0.0, math.nan, math.inf):
        message.info.resolution = number
        with pytest.raises(ShapeError, match=f"resolution is {number}"):
            shapes.occupancy_grid(message)
    message.info.resolution, message.info.origin.orientation.w = 1.0, math.nan
    with pytest.raises(ShapeError, match="origin is not finite"):
        shapes.occupancy_grid(message)


@pytest.mark.slow
@given(st.lists(st.tuples(*[st.floats()] * 7), max_size=20))
def test_any_path(poses: list[tuple[float, ...]]) -> None:
    message = Path(poses=[PoseStamped() for _ in poses])
    for each, (x, y, z, a, b, c, d) in zip(message.poses, poses, strict=True):
        each.pose.position.x, each.pose.position.y, each.pose.position.z = x, y, z
        turn = each.pose.orientation
        turn.x, turn.y, turn.z, turn.w = a, b, c, d
    facts, blob = shapes.path(message)
    numbers = np.frombuffer(blob, np.float32)
    assert facts["count"] == sum(all(abs(value) < 1e30 for value in pose[:3]) for pose in poses)
    assert len(numbers) == 7 * facts["count"] and np.isfinite(numbers).all()


@pytest.mark.parametrize("kind", sorted(SHAPE_FUNCTIONS))
def test_default_messages_of_every_type(kind: str) -> None:
    from pyros1.msgs import load_message

    try:
        facts, blob = SHAPE_FUNCTIONS[kind](load_message(kind)())
    except ShapeError:
        assert kind == "sensor_msgs/PointCloud2"  # without fields
    else:
        json.dumps(facts, allow_nan=False)
        assert isinstance(blob, bytes)


@pytest.mark.parametrize("number", [math.nan, math.inf, -1e300, 3.4e38])
def test_what_a_graphics_card_cannot_draw_is_left_out(number: float) -> None:
    corners = [Point32(1, 2, 3), Point32(0, number, 0)]
    facts, blob = shapes.polygon(PolygonStamped(polygon=Polygon(points=corners)))
    assert (facts["count"], struct.unpack("<3f", blob)) == (1, (1.0, 2.0, 3.0))
    facts, blob = shapes.grid_cells(GridCells(cell_width=number, cells=[Point(1, 2, 3), Point(number, 0, 0)]))
    assert (facts["count"], facts["more"], facts["size"], len(blob)) == (1, 1, [None, 0.0], 12)
    force = WrenchStamped()
    force.wrench.force.x = number
    assert shapes.wrench(force)[0]["straight"] == [None, 0.0, 0.0]
    pose = PoseWithCovarianceStamped()
    pose.pose.pose.orientation.w, pose.pose.covariance = number, [number] * 36
    left_out = {"kind": "poses", "count": 0, "odd": "1 of 1 omitted: not finite"}
    assert shapes.pose_with_covariance(pose) == (left_out, b"")


def test_a_covariance_is_an_ellipsoid() -> None:
    message = PoseWithCovarianceStamped()
    assert "spread" not in shapes.pose_with_covariance(message)[0]  # not known
    covariance = [0.0] * 36
    covariance[0], covariance[7], covariance[14], covariance[35] = 0.25, 4.0, 1.0, 0.09
    message.pose.covariance = covariance
    facts, _ = shapes.pose_with_covariance(message)
    lengths = sorted(sum(value * value for value in axis) ** 0.5 for axis in facts["spread"])
    assert lengths == pytest.approx([0.5, 1.0, 2.0])
    assert facts["turn"] == pytest.approx(0.3)


@given(st.lists(st.floats(), min_size=36, max_size=36))
def test_any_covariance(covariance: list[float]) -> None:
    message = PoseWithCovarianceStamped()
    message.pose.covariance = covariance
    json.dumps(shapes.pose_with_covariance(message)[0], allow_nan=False)


def test_numbers_with_units() -> None:
    wrench = WrenchStamped()
    wrench.wrench.force.z, wrench.wrench.torque.x = 2.0, float("nan")
    facts, _ = shapes.wrench(wrench)
    assert (facts["straight"], facts["around"], facts["units"]) == ([0, 0, 2.0], [None, 0, 0], ["N", "N m"])
    facts, _ = SHAPE_FUNCTIONS["sensor_msgs/Temperature"](Temperature(temperature=21.5))
    assert (facts["value"], facts["unit"]) == (21.5, "\u00b0C")


def test_of_too_many_cells_some_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shapes, "MAX_POSES", 2)
    facts, blob = shapes.grid_cells(GridCells(cell_width=0.5, cell_height=0.25, cells=[Point(1.0, 2.0, 0.0)] * 5))
    assert (facts["count"], facts["more"], facts["size"]) == (2, 3, [0.5, 0.25])
    assert struct.unpack("<6f", blob) == (1.0, 2.0, 0.0) * 2


def test_efforts_that_are_known() -> None:
    message = JointState(name=["a", "b", "c", "without"], effort=[1.5, math.nan, -2.0])
    assert SHAPE_FUNCTIONS["sensor_msgs/JointState"](message) == (
        {"kind": "efforts", "names": ["a", "c"], "efforts": [1.5, -2]},
        b"",
    )
    many = JointState(name=["j"] * 1500, effort=[1.0] * 1500)
    assert len(SHAPE_FUNCTIONS["sensor_msgs/JointState"](many)[0]["names"]) == 1000
