"""Thins out point clouds and laser scans. No I/O.

The remaining points are copied unchanged, with all fields; nothing is averaged, so intensities, rings and times stay
valid.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError

_COORDINATES = {7: "f4", 8: "f8"}
"""numpy's names for PointField.FLOAT32 and FLOAT64."""
_MAX_INDEX = 1 << 20
"""Maximum cube number in each direction from the origin; points further away are left out."""


def thin_cloud(cloud: Any, every: int) -> Any:
    """Return a sensor_msgs/PointCloud2 with every n-th point of each row; an organized cloud keeps its rows, such as a
    scanner's rings.

    Args:
        cloud: the cloud.
        every: n.

    Raises:
        MessageError: the cloud has fewer bytes than its size says.
    """
    points = _points(cloud)[:, ::every]
    return _with_points(cloud, points, is_dense=cloud.is_dense)


def voxel_cloud(cloud: Any, edge: float) -> Any:
    """Return a sensor_msgs/PointCloud2 with the first point in each cube of a grid; height is 1.

    Points that are not finite are left out, as are points more than a million cubes from the origin.

    Args:
        cloud: the cloud, with fields x, y and z.
        edge: the edge of a cube in metres.

    Raises:
        MessageError: the cloud lacks these fields, or has fewer bytes than its size says.
    """
    rows = _points(cloud)
    points = rows.reshape(-1, rows.shape[2])
    with np.errstate(all="ignore"):  # warnings about values that are not finite
        cubes = [np.floor(_coordinate(cloud, points, name).astype(np.float64) / edge) for name in "xyz"]
    has_place = np.logical_and.reduce([np.abs(cube) < _MAX_INDEX for cube in cubes])
    numbers = np.zeros(np.count_nonzero(has_place), np.int64)
    for cube in cubes:
        numbers = numbers * (2 * _MAX_INDEX) + cube[has_place].astype(np.int64) + _MAX_INDEX
    first = np.sort(np.unique(numbers, return_index=True)[1])
    return _with_points(cloud, points[has_place][first][np.newaxis], is_dense=True)


def thin_scan(scan: Any, every: int) -> Any:
    """Return a sensor_msgs/LaserScan with every n-th beam.

    Args:
        scan: the scan.
        every: n.
    """
    count = len(scan.ranges)
    ranges = scan.ranges[::every]
    intensities = scan.intensities[::every] if len(scan.intensities) == count else scan.intensities
    increment = scan.angle_increment * every
    return type(scan)(
        header=scan.header,
        angle_min=scan.angle_min,
        angle_max=scan.angle_min + increment * max(0, len(ranges) - 1),
        angle_increment=increment,
        time_increment=scan.time_increment * every,
        scan_time=scan.scan_time,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=ranges,
        intensities=intensities,
    )


def _points(cloud: Any) -> NDArray[np.uint8]:
    """Return the bytes of the points, of shape (height, width, point_step)."""
    height, width, size, step = cloud.height, cloud.width, cloud.point_step, cloud.row_step
    data = np.frombuffer(cloud.data, np.uint8)
    if not height or not width or not size:
        return np.empty((height, width, size), np.uint8)[:, :0] if size else np.empty((0, 0, 1), np.uint8)
    if step < width * size or len(data) < step * (height - 1) + width * size:
        raise MessageError(f"a cloud with {len(data)} bytes, too few for {width} x {height} points of {size} bytes")
    strides = (step, size, 1)
    return np.lib.stride_tricks.as_strided(data, (height, width, size), strides, writeable=False)


def _coordinate(cloud: Any, points: NDArray[np.uint8], name: str) -> NDArray[Any]:
    field = next((each for each in cloud.fields if each.name == name), None)
    code = _COORDINATES.get(field.datatype) if field is not None else None
    if field is None or code is None:
        raise MessageError(f"a cloud whose points have no {name} as float32 or float64")
    size = int(code[1])
    if field.offset + size > cloud.point_step:
        raise MessageError(f"a cloud whose {name} lies outside its points")
    columns = np.ascontiguousarray(points[:, field.offset : field.offset + size])
    order = ">" if cloud.is_bigendian else "<"
    values: NDArray[Any] = columns.view(order + code)[:, 0]
    return values


def _with_points(cloud: Any, points: NDArray[np.uint8], *, is_dense: bool) -> Any:
    """Return a cloud with other points, of shape (height, width, point_step)."""
    height, width, _ = points.shape
    return type(cloud)(
        header=cloud.header,
        height=height,
        width=width,
        fields=cloud.fields,
        is_bigendian=cloud.is_bigendian,
        point_step=cloud.point_step,
        row_step=width * cloud.point_step,
        data=points.tobytes(),
        is_dense=is_dense,
    )
