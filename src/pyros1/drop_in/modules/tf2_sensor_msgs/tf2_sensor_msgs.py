"""Transforms a sensor_msgs/PointCloud2 to another frame with numpy, and registers the function with tf2_ros."""

from __future__ import annotations

from typing import Any

import numpy as np
import rospy
import tf2_ros
from tf2_geometry_msgs._rotation import from_quaternion
from tf2_geometry_msgs.tf2_geometry_msgs import from_msg_msg, to_msg_msg, transform_to_kdl

from pyros1.msgs.sensor_msgs.msg import PointCloud2

_NUMPY_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""Data type in sensor_msgs/PointField -> numpy's name of the type."""


def __getattr__(name: str) -> Any:
    if name in ("read_points", "create_cloud"):  # stock imports them here
        from sensor_msgs import point_cloud2  # type: ignore[import-not-found,unused-ignore]

        return getattr(point_cloud2, name)
    raise AttributeError(f"pyros1 has no tf2_sensor_msgs.{name}")


def do_transform_cloud(cloud: Any, transform: Any) -> Any:
    """Return a PointCloud2 in another frame: the fields x, y and z change, others do not.

    Args:
        cloud: the cloud, with fields x, y and z of floats, in any order.
        transform: a geometry_msgs/TransformStamped; the result gets its header.

    Returns:
        A cloud of height 1.

    Raises:
        ValueError: there is no field x, y or z, or the data is too short.
    """
    fields = sorted((field for field in cloud.fields if field.datatype in _NUMPY_TYPES), key=lambda field: field.offset)
    names = [field.name for field in fields]
    if not {"x", "y", "z"} <= {*names}:
        raise ValueError(f"a point cloud must have fields x, y and z; this one has {', '.join(names) or 'none'}")
    point_step = max(
        (field.offset + field.count * np.dtype(_NUMPY_TYPES[field.datatype]).itemsize for field in fields), default=0
    )
    points = _to_records(cloud, _make_dtype(fields, cloud.point_step, ">" if cloud.is_bigendian else "<"))
    result = np.zeros(len(points), _make_dtype(fields, point_step, "<"))
    for name in names:
        result[name] = points[name]
    v, q = transform.transform.translation, transform.transform.rotation
    rotation = np.array(from_quaternion(q.x, q.y, q.z, q.w))
    xyz = np.stack([points[axis].astype(np.float64) for axis in "xyz"], axis=-1) @ rotation.T + (v.x, v.y, v.z)
    for column, axis in enumerate("xyz"):
        result[axis] = xyz[:, column]
    return PointCloud2(
        header=transform.header,
        height=1,
        width=len(result),
        is_dense=False,
        is_bigendian=False,
        fields=cloud.fields,
        point_step=point_step,
        row_step=point_step * len(result),
        data=result.tobytes(),
    )


def _make_dtype(fields: list[Any], point_step: int, byte_order: str) -> np.dtype[Any]:
    formats = [
        (byte_order + _NUMPY_TYPES[field.datatype], (field.count,))
        if field.count != 1
        else byte_order + _NUMPY_TYPES[field.datatype]
        for field in fields
    ]
    return np.dtype(
        {
            "names": [field.name for field in fields],
            "formats": formats,
            "offsets": [field.offset for field in fields],
            "itemsize": point_step,
        }
    )


def _to_records(cloud: Any, layout: np.dtype[Any]) -> Any:
    """Return the points of a cloud as an array of records, without the bytes between its rows."""
    rows = np.frombuffer(bytes(cloud.data), np.uint8, cloud.height * cloud.row_step).reshape(cloud.height, -1)
    return np.ascontiguousarray(rows[:, : cloud.width * cloud.point_step]).reshape(-1).view(layout)


tf2_ros.ConvertRegistration().add_to_msg(PointCloud2, to_msg_msg)
tf2_ros.ConvertRegistration().add_from_msg(PointCloud2, from_msg_msg)
tf2_ros.TransformRegistration().add(PointCloud2, do_transform_cloud)
