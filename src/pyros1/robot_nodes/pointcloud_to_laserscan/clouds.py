"""Converts sensor_msgs/PointCloud2 to numpy arrays and back (no I/O)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.sensor_msgs.msg import PointCloud2, PointField

_NUMPY_TYPES: Mapping[int, str] = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""Datatype in a sensor_msgs/PointField -> numpy's name for it."""
_DATATYPES: Mapping[str, int] = {name: datatype for datatype, name in _NUMPY_TYPES.items()}


def read_positions(cloud: Any) -> NDArray[np.float64]:
    """Return the positions of all points of a cloud, including NaN, as an array of shape (n, 3).

    Args:
        cloud: a sensor_msgs/PointCloud2. Its data may be bytes or an array of bytes.

    Raises:
        MessageError: the cloud has no x, y or z, or too few bytes for its size.
    """
    data = np.frombuffer(cloud.data, np.uint8)
    height, width, point_step, row_step = cloud.height, cloud.width, cloud.point_step, cloud.row_step
    if not height or not width:
        return np.empty((0, 3))
    if row_step < width * point_step or len(data) < row_step * (height - 1) + width * point_step:
        raise MessageError(f"{len(data)} bytes are too few for {width} x {height} points of {point_step} bytes")
    fields = [_find_field(cloud, name) for name in "xyz"]  # before allocating: there may be any number of empty points
    positions = np.empty((height, width, 3))
    for axis, (offset, dtype) in enumerate(fields):
        positions[:, :, axis] = np.ndarray((height, width), dtype, data, offset, (row_step, point_step))
    return positions.reshape(-1, 3)


def _find_field(cloud: Any, name: str) -> tuple[int, np.dtype[Any]]:
    """Return the offset of a field within a point, and its type."""
    field = next((field for field in cloud.fields if field.name == name), None)
    type_name = _NUMPY_TYPES.get(field.datatype) if field is not None else None
    if field is None or type_name is None:
        found = one_line(", ".join(each.name for each in cloud.fields), 100)
        raise MessageError(f"the points have no coordinate {name}, only {found or 'nothing'}")
    dtype = np.dtype((">" if cloud.is_bigendian else "<") + type_name)
    if field.offset + dtype.itemsize > cloud.point_step:
        raise MessageError(f"{name} is outside the {cloud.point_step} bytes of a point")
    return field.offset, dtype


def make_cloud(header: Any, columns: Mapping[str, NDArray[Any]]) -> PointCloud2:
    """Return a sensor_msgs/PointCloud2 with one row of points.

    Args:
        header: the message's header.
        columns: the values of each field, in the fields' order: arrays of the same length, of float32 or int32.
    """
    fields, record = [], []
    offset = 0
    for name, values in columns.items():
        code = values.dtype.str[1:]
        fields.append(PointField(name=name, offset=offset, datatype=_DATATYPES[code], count=1))
        record.append((name, "<" + code))
        offset += values.dtype.itemsize
    count = len(next(iter(columns.values())))
    points = np.empty(count, record)
    for name, values in columns.items():
        points[name] = values
    return PointCloud2(
        header=header,
        height=1,
        width=count,
        fields=fields,
        point_step=offset,
        row_step=count * offset,
        data=points.tobytes(),
    )
