"""Clouds and scans that are thinned out keep whole points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pyros1.bridge.conversions.points import thin_cloud, thin_scan, voxel_cloud
from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2, PointField
from pyros1.msgs.std_msgs.msg import Header

FIELDS = [
    PointField("x", 0, PointField.FLOAT32, 1),
    PointField("y", 4, PointField.FLOAT32, 1),
    PointField("z", 8, PointField.FLOAT32, 1),
    PointField("ring", 12, PointField.UINT16, 1),
]
DTYPE = np.dtype({"names": ["x", "y", "z", "ring"], "formats": ["<f4"] * 3 + ["<u2"], "itemsize": 16})


def cloud(points: Any, row_count: int = 1, padding: int = 0, **changes: Any) -> Any:
    """Return a cloud of rows of points; each row has some bytes more at its end."""
    array = np.array([tuple(point) for point in points], DTYPE).reshape(row_count, -1)
    data = b"".join(row.tobytes() + b"?" * padding for row in array)
    width = array.shape[1]
    message = PointCloud2(
        Header(frame_id="lidar"), row_count, width, FIELDS, False, 16, 16 * width + padding, data, False
    )
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def points(message: Any) -> Any:
    assert message.row_step == message.width * message.point_step
    assert len(message.data) == message.height * message.row_step
    assert (message.header.frame_id, message.fields) == ("lidar", FIELDS)
    return [tuple(point) for point in np.frombuffer(message.data, DTYPE).tolist()]


def rows(count: int, width: int) -> list[tuple[float, ...]]:
    return [(float(column), float(row), 0.5, 10 * row + column) for row in range(count) for column in range(width)]


def test_every_third_point() -> None:
    thin = thin_cloud(cloud(rows(1, 7)), 3)
    assert (thin.height, thin.width, thin.is_dense) == (1, 3, False)
    assert [point[3] for point in points(thin)] == [0, 3, 6]


def test_rows_of_organized_clouds_remain() -> None:
    thin = thin_cloud(cloud(rows(3, 5), 3, padding=4), 2)
    assert (thin.height, thin.width) == (3, 3)
    assert [point[3] for point in points(thin)] == [0, 2, 4, 10, 12, 14, 20, 22, 24]


def test_one_point_of_each_cube() -> None:
    given = [(0.05, 0, 0, 1), (0.09, 0.01, 0.02, 2), (0.11, 0, 0, 3), (-0.01, 0, 0, 4), (0.19, 0.09, 0, 5)]
    thin = voxel_cloud(cloud([*given, (float("nan"), 0, 0, 6), (0, float("inf"), 0, 7), (0, 0, 1e30, 8)]), 0.1)
    assert (thin.height, thin.is_dense) == (1, True)
    assert [point[3] for point in points(thin)] == [1, 3, 4]
    assert points(thin)[1] == pytest.approx((0.11, 0, 0, 3))


@pytest.mark.parametrize("seed", range(5))
def test_cubes_of_random_clouds(seed: int) -> None:
    random = np.random.default_rng(seed)
    places = random.normal(0, 3, (2000, 3)).astype(np.float32)
    given = [(*place, number) for number, place in enumerate(places)]
    thin = voxel_cloud(cloud(given, 20, padding=8), 0.5)
    seen: dict[tuple[int, ...], int] = {}
    for number, place in enumerate(places):
        seen.setdefault(tuple(int(np.floor(float(value) / 0.5)) for value in place), number)
    assert [point[3] for point in points(thin)] == [*seen.values()]


def test_big_endian_doubles() -> None:
    fields = [PointField(name, 8 * n, PointField.FLOAT64, 1) for n, name in enumerate("xyz")]
    data = np.array([[0.1, 0, 0], [0.2, 0, 0], [1.5, 0, 0], [2.5, 0, 0]], ">f8").tobytes()
    thin = voxel_cloud(PointCloud2(Header(), 1, 4, fields, True, 24, 96, data, True), 1.0)
    assert thin.is_bigendian and np.frombuffer(thin.data, ">f8").reshape(-1, 3)[:, 0].tolist() == [0.1, 1.5, 2.5]


@pytest.mark.parametrize("convert", [lambda message: thin_cloud(message, 2), lambda message: voxel_cloud(message, 1.0)])
def test_empty_clouds(convert: Any) -> None:
    for changes in ({"width": 0, "data": b""}, {"height": 0, "data": b""}):
        thin = convert(cloud(rows(1, 3), **changes))
        assert thin.data == b"" and thin.width * thin.height == 0


@pytest.mark.parametrize("convert", [lambda message: thin_cloud(message, 2), lambda message: voxel_cloud(message, 1.0)])
def test_clouds_that_lie_about_their_size(convert: Any) -> None:
    for changes in ({"width": 4}, {"height": 2}, {"row_step": 10}, {"point_step": 1 << 31}, {"data": b""}):
        with pytest.raises(MessageError, match="too few for"):
            convert(cloud(rows(1, 3), **changes))


def test_clouds_without_places() -> None:
    for fields, problem in (
        (FIELDS[:2], "no z"),
        ([*FIELDS[:2], PointField("z", 8, PointField.INT32, 1)], "no z"),
        ([*FIELDS[:2], PointField("z", 13, PointField.FLOAT32, 1)], "outside"),
    ):
        with pytest.raises(MessageError, match=problem):
            voxel_cloud(cloud(rows(1, 3), fields=fields), 1.0)


def test_every_second_beam() -> None:
    scan = LaserScan(
        header=Header(frame_id="laser"), angle_min=-1.0, angle_max=1.0, angle_increment=0.5, time_increment=0.01,
        scan_time=0.1, range_min=0.2, range_max=30.0, ranges=(1.0, 2.0, 3.0, 4.0, 5.0), intensities=(1, 2, 3, 4, 5),
    )  # fmt: skip
    thin = thin_scan(scan, 2)
    assert (thin.ranges, thin.intensities) == ((1.0, 3.0, 5.0), (1, 3, 5))
    assert (thin.angle_min, thin.angle_max, thin.angle_increment, thin.time_increment) == (-1.0, 1.0, 1.0, 0.02)
    assert (thin.header.frame_id, thin.scan_time, thin.range_min, thin.range_max) == ("laser", 0.1, 0.2, 30.0)
    thin = thin_scan(scan, 4)
    assert (thin.ranges, thin.angle_max) == ((1.0, 5.0), 1.0)
    scan.ranges, scan.intensities = (1.0, 2.0, 3.0, 4.0), ()
    thin = thin_scan(scan, 3)
    assert (thin.ranges, thin.intensities, thin.angle_max) == ((1.0, 4.0), (), 0.5)
    scan.intensities = (7.0, 8.0)  # nobody knows of which beams
    assert thin_scan(scan, 3).intensities == (7.0, 8.0)
    scan.ranges = ()
    assert (thin_scan(scan, 3).ranges, thin_scan(scan, 3).angle_max) == ((), -1.0)
