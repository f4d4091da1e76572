"""Converts point clouds to structured arrays with the cloud's fields, and back."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.sensor_msgs.msg import PointCloud2, PointField
from ros_numpy.registry import converts_from_numpy, converts_to_numpy

DUMMY_FIELD_PREFIX = "__"
"""Prefix of the names of padding fields."""
_MAX_POINT_SIZE = 1 << 16
"""Maximum size of a point in an empty cloud, in bytes."""
type_mappings: list[tuple[int, Any]] = [
    (PointField.INT8, np.dtype("int8")),
    (PointField.UINT8, np.dtype("uint8")),
    (PointField.INT16, np.dtype("int16")),
    (PointField.UINT16, np.dtype("uint16")),
    (PointField.INT32, np.dtype("int32")),
    (PointField.UINT32, np.dtype("uint32")),
    (PointField.FLOAT32, np.dtype("float32")),
    (PointField.FLOAT64, np.dtype("float64")),
]
pftype_to_nptype = dict(type_mappings)
nptype_to_pftype = {nptype: pftype for pftype, nptype in type_mappings}
pftype_sizes = {pftype: nptype.itemsize for pftype, nptype in type_mappings}

__getattr__ = module_getattr(__name__)


@converts_to_numpy(PointField, plural=True)
def fields_to_dtype(fields: Sequence[Any], point_step: int, is_bigendian: bool = False) -> list[tuple[Any, ...]]:
    """Convert the fields of a cloud to a numpy structured type.

    Args:
        fields: the cloud's fields.
        point_step: number of bytes per point.
        is_bigendian: whether numbers are big-endian.

    Returns:
        (name, type) of each field, or (name, type, shape); padding fields have names that begin with two underscores.
    """
    types: list[tuple[Any, ...]] = []
    end = 0
    for field in sorted(fields, key=lambda field: field.offset):
        while end < field.offset:
            types.append((f"{DUMMY_FIELD_PREFIX}{end}", np.uint8))
            end += 1
        dtype = pftype_to_nptype[field.datatype].newbyteorder(">" if is_bigendian else "<")
        types.append((field.name, dtype) if field.count == 1 else (field.name, dtype, (field.count,)))
        end += pftype_sizes[field.datatype] * field.count
    types += [(f"{DUMMY_FIELD_PREFIX}{offset}", np.uint8) for offset in range(end, point_step)]
    return types


@converts_from_numpy(PointField, plural=True)
def dtype_to_fields(dtype: Any) -> list[Any]:
    """Convert a numpy structured type to the fields of a cloud."""
    fields = []
    for name in dtype.names:
        field_type, offset = dtype.fields[name][:2]
        count, shape = 1, field_type.shape
        if field_type.subdtype:
            field_type, shape = field_type.subdtype
            count = int(np.prod(shape))
        fields.append(PointField(name, offset, nptype_to_pftype[field_type.newbyteorder("=")], count))
    return fields


@converts_to_numpy(PointCloud2)
def pointcloud2_to_array(cloud_msg: Any, squeeze: bool = True) -> Any:
    """Convert a cloud to a structured array with its fields.

    Args:
        cloud_msg: the cloud.
        squeeze: whether a cloud of one row has the shape (width,), not (1, width).

    Raises:
        ValueError: data, points and fields are inconsistent.
    """
    shape, point_step = (cloud_msg.height, cloud_msg.width), cloud_msg.point_step
    row_step = cloud_msg.row_step or point_step * cloud_msg.width
    data = cloud_msg.data if isinstance(cloud_msg.data, (bytes, bytearray, memoryview)) else bytes(cloud_msg.data)
    # numpy does not check empty buffers, and creating a data type of gigabytes needs even more memory.
    if len(data) < row_step * (shape[0] - 1) + point_step * shape[1] or row_step < point_step * shape[1]:
        raise ValueError(f"the {len(data)} bytes of the cloud do not fit its size: {shape[0]} rows of {row_step} bytes")
    for field in cloud_msg.fields:
        end = field.offset + field.count * pftype_sizes.get(field.datatype, 0)
        if end > point_step:
            raise ValueError(f"the field {field.name} ends at byte {end} of points that have {point_step}")
    if point_step > max(len(data), _MAX_POINT_SIZE):
        raise ValueError(f"the cloud has points of {point_step} bytes, but {len(data)} bytes in all")
    dtype = np.dtype(fields_to_dtype(cloud_msg.fields, point_step, cloud_msg.is_bigendian))
    points: Any = np.ndarray(shape, dtype, data, strides=(row_step, point_step))
    points = points[[name for name in dtype.names or () if not name.startswith(DUMMY_FIELD_PREFIX)]]
    return points.reshape(cloud_msg.width) if squeeze and cloud_msg.height == 1 else points


@converts_from_numpy(PointCloud2)
def array_to_pointcloud2(cloud_arr: Any, stamp: Any = None, frame_id: str | None = None) -> Any:
    """Convert a structured array to a cloud.

    Args:
        cloud_arr: array of shape (width,) or (height, width).
        stamp: time of the cloud.
        frame_id: frame of the cloud.
    """
    cloud_arr = np.atleast_2d(cloud_arr)
    message = PointCloud2()
    if stamp is not None:
        message.header.stamp = stamp
    if frame_id is not None:
        message.header.frame_id = frame_id
    message.height, message.width = cloud_arr.shape
    message.fields = dtype_to_fields(cloud_arr.dtype)
    message.is_bigendian = sys.byteorder != "little"
    message.point_step = cloud_arr.dtype.itemsize
    message.row_step = message.point_step * cloud_arr.shape[1]
    names = cloud_arr.dtype.names
    message.is_dense = all(np.isfinite(cloud_arr[name]).all() for name in names if cloud_arr[name].dtype.kind == "f")
    message.data = cloud_arr.tobytes()
    return message


def merge_rgb_fields(cloud_arr: Any) -> Any:
    """Return an array with the fields r, g and b merged into ``rgb``, a float32 whose bits hold the three colours."""
    r, g, b = (np.asarray(cloud_arr[name], dtype=np.uint32) for name in "rgb")
    rgb = ((r << 16) | (g << 8) | b).view(np.float32)
    kept_names = [name for name in cloud_arr.dtype.names if name not in ("r", "g", "b")]
    dtype = [(name, cloud_arr.dtype.fields[name][0]) for name in kept_names]
    result = np.zeros(cloud_arr.shape, np.dtype([*dtype, ("rgb", np.float32)]))
    for name in kept_names:
        result[name] = cloud_arr[name]
    result["rgb"] = rgb
    return result


def split_rgb_field(cloud_arr: Any) -> Any:
    """Return an array with the field ``rgb``, whose bits hold three colours, split into r, g and b."""
    rgb = np.ascontiguousarray(cloud_arr["rgb"]).view(np.uint32)
    kept_names = [name for name in cloud_arr.dtype.names if name != "rgb"]
    dtype = [(name, cloud_arr.dtype.fields[name][0]) for name in kept_names]
    result = np.zeros(cloud_arr.shape, np.dtype([*dtype, *((color, np.uint8) for color in "rgb")]))
    for name in kept_names:
        result[name] = cloud_arr[name]
    for color, shift in (("r", 16), ("g", 8), ("b", 0)):
        result[color] = (rgb >> shift) & 255
    return result


def get_xyz_points(cloud_array: Any, remove_nans: bool = True, dtype: Any = float) -> Any:
    """Return the coordinates of points as an array of shape (..., 3).

    Args:
        cloud_array: array whose elements have x, y and z.
        remove_nans: whether to omit points with values that are not finite.
        dtype: type of the numbers.
    """
    if remove_nans:
        is_finite = np.isfinite(cloud_array["x"]) & np.isfinite(cloud_array["y"]) & np.isfinite(cloud_array["z"])
        cloud_array = cloud_array[is_finite]
    points = np.zeros((*cloud_array.shape, 3), dtype=dtype)
    for column, name in enumerate("xyz"):
        points[..., column] = cloud_array[name]
    return points


def pointcloud2_to_xyz_array(cloud_msg: Any, remove_nans: bool = True) -> Any:
    """Return the coordinates of a cloud's points as an array of shape (..., 3)."""
    return get_xyz_points(pointcloud2_to_array(cloud_msg), remove_nans=remove_nans)
