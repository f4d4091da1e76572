"""Points of sensor_msgs/PointCloud2 messages, as tuples (https://wiki.ros.org/pcl/Overview)."""

from __future__ import annotations

import struct
from collections import namedtuple
from collections.abc import Iterable, Iterator, Sequence
from itertools import compress, starmap
from typing import Any

import numpy as np

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.sensor_msgs.msg import PointCloud2, PointField

_DATATYPES = {
    PointField.INT8: ("b", 1),
    PointField.UINT8: ("B", 1),
    PointField.INT16: ("h", 2),
    PointField.UINT16: ("H", 2),
    PointField.INT32: ("i", 4),
    PointField.UINT32: ("I", 4),
    PointField.FLOAT32: ("f", 4),
    PointField.FLOAT64: ("d", 8),
}
_MAX_REPEATED_CODES = 4096

__getattr__ = module_getattr(__name__)


def read_points(
    cloud: Any, field_names: Sequence[str] | None = None, skip_nans: bool = False, uvs: Iterable[Any] = ()
) -> Iterator[tuple[Any, ...]]:
    """Yield the points of a cloud.

    Args:
        cloud: the message.
        field_names: fields to read; None for all. The values come in the order of the fields in memory.
        skip_nans: whether to omit points with a NaN in one of these fields.
        uvs: (column, row) of the points to read; empty for all.

    Raises:
        AssertionError: ``cloud`` is not a sensor_msgs/PointCloud2.
        struct.error: there is less data than the cloud's size requires.
    """
    assert getattr(cloud, "_type", "") == "sensor_msgs/PointCloud2", "cloud is not a sensor_msgs.msg.PointCloud2"
    layout = struct.Struct(_get_struct_fmt(cloud.is_bigendian, cloud.fields, field_names))
    data = bytes(cloud.data) if isinstance(cloud.data, (list, tuple)) else cloud.data
    pixels = list(uvs)
    if layout.size and not pixels and cloud.width * cloud.height > len(data):
        raise struct.error(f"the cloud has {cloud.height} rows of {cloud.width} points, but {len(data)} bytes of data")
    if (
        pixels
        or layout.size > cloud.point_step
        or len(data) < cloud.row_step * (cloud.height - 1) + (cloud.point_step * cloud.width)
    ):
        yield from _read_one_by_one(cloud, data, layout, pixels, skip_nans)
        return
    points = struct.Struct(f"{layout.format}{cloud.point_step - layout.size}x")
    for row in range(cloud.height) if cloud.width and cloud.point_step else ():
        start = row * cloud.row_step
        row_data = memoryview(data)[start : start + cloud.point_step * cloud.width]
        if skip_nans:
            is_valid = _find_valid_points(row_data, cloud, field_names)
            yield from compress(points.iter_unpack(row_data), is_valid)
        else:
            yield from points.iter_unpack(row_data)


def _read_one_by_one(
    cloud: Any, data: Any, layout: struct.Struct, pixels: list[Any], skip_nans: bool
) -> Iterator[tuple[Any, ...]]:
    # A cloud may claim to have more points than fit into memory.
    for u, v in pixels or ((u, v) for v in range(cloud.height if cloud.width else 0) for u in range(cloud.width)):
        point = layout.unpack_from(data, cloud.row_step * v + cloud.point_step * u)
        if not (skip_nans and any(value != value for value in point)):  # noqa: PLR0124  only NaN is not itself
            yield point


def _find_valid_points(row: memoryview, cloud: Any, field_names: Sequence[str] | None) -> list[bool]:
    """Return a list with an element for each point in a row: True if none of the point's fields is NaN."""
    is_valid = np.ones(cloud.width, bool)
    order = ">" if cloud.is_bigendian else "<"
    for field in cloud.fields:
        code = _DATATYPES[field.datatype][0]
        if code in "fd" and (field_names is None or field.name in field_names):
            shape, strides = (cloud.width, field.count), (cloud.point_step, struct.calcsize(code))
            values = np.ndarray(shape, order + code.replace("f", "f4").replace("d", "f8"), row, field.offset, strides)
            is_valid &= ~np.isnan(values).any(axis=1)
    return is_valid.tolist()


def read_points_list(
    cloud: Any, field_names: Sequence[str] | None = None, skip_nans: bool = False, uvs: Iterable[Any] = ()
) -> list[Any]:
    """Return the points of a cloud as named tuples; see :func:`read_points`."""
    assert getattr(cloud, "_type", "") == "sensor_msgs/PointCloud2", "cloud is not a sensor_msgs.msg.PointCloud2"
    names = [field.name for field in cloud.fields] if field_names is None else field_names
    point_class = namedtuple("Point", names)  # type: ignore[misc]
    return list(map(point_class._make, read_points(cloud, field_names, skip_nans, uvs)))


def create_cloud(header: Any, fields: Sequence[Any], points: Any) -> Any:
    """Return a cloud of one row.

    Args:
        header: header of the cloud.
        fields: fields of the cloud (sensor_msgs/PointField).
        points: the points, each a sequence with one value for each element of each field, in the order of the fields
            in memory; or an array of shape (points, values).

    Raises:
        struct.error: a point has the wrong number of values, or a value does not fit its field.
    """
    layout = struct.Struct(_get_struct_fmt(False, fields))
    width = len(points)
    data = _pack_array(layout, fields, points)
    if data is None:
        data = b"".join(starmap(layout.pack, points))
    return PointCloud2(
        header=header,
        height=1,
        width=width,
        is_dense=False,
        is_bigendian=False,
        fields=fields,
        point_step=layout.size,
        row_step=layout.size * width,
        data=bytes(data),
    )


def _pack_array(layout: struct.Struct, fields: Sequence[Any], points: Any) -> bytes | bytearray | None:
    """Return the data of an array of points if all fields are floats; None if they must be packed one by one."""
    if not isinstance(points, np.ndarray) or points.ndim != 2 or points.dtype.kind not in "fiu":
        return None
    codes = [_DATATYPES[field.datatype][0] for field in fields]
    if any(code not in "fd" for code in codes) or sum(field.count for field in fields) != points.shape[1]:
        return None
    data, first_column = bytearray(layout.size * len(points)), 0
    for field in sorted(fields, key=lambda field: field.offset):
        code, size = _DATATYPES[field.datatype]
        shape, strides = (len(points), field.count), (layout.size, size)
        target: Any = np.ndarray(shape, "<f4" if code == "f" else "<f8", data, field.offset, strides)
        target[:] = points[:, first_column : first_column + field.count]
        first_column += field.count
    return data


def create_cloud_xyz32(header: Any, points: Any) -> Any:
    """Return a cloud with the 32-bit fields x, y and z; see :func:`create_cloud`."""
    fields = [PointField(name, offset, PointField.FLOAT32, 1) for name, offset in (("x", 0), ("y", 4), ("z", 8))]
    return create_cloud(header, fields, points)


def _get_struct_fmt(is_bigendian: bool, fields: Iterable[Any], field_names: Sequence[str] | None = None) -> str:
    """Return the format of a point for `struct`, for programs that write points themselves."""
    parts, end = [">" if is_bigendian else "<"], 0
    for field in sorted(fields, key=lambda field: field.offset):
        if field_names is not None and field.name not in field_names:
            continue
        if field.datatype not in _DATATYPES:
            raise ValueError(f"field [{field.name}] has the unknown type {field.datatype}")
        if field.offset > end:
            parts.append(_repeat("x", field.offset - end))
            end = field.offset
        code, size = _DATATYPES[field.datatype]
        parts.append(_repeat(code, field.count))
        end += size * field.count
    return "".join(parts)


def _repeat(code: str, count: int) -> str:
    """Return the format of several equal items: the same string as stock's, unless there are very many items."""
    return code * count if count <= _MAX_REPEATED_CODES else f"{count}{code}"
