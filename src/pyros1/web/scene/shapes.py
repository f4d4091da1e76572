"""Converts messages to shapes: a description as JSON, and a block of numbers (no I/O).

Positions are in metres, in the frame of the message's header; angles are in radians.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.web.scene.clouds import Bounds, point_cloud, point_cloud2
from pyros1.web.scene.shape import MAX_MAGNITUDE, Shape, ShapeError

MAX_POSES = 20_000
MAX_CELLS = 64 << 20
MAX_JOINTS = 1_000
_UNKNOWN = -1
"""Value of a map's unknown cells."""


def laser_scan(scan: Any) -> Shape:
    """Return the shape for a scan: its ranges as float32, then any intensities. As in rviz, missing intensities are 0.

    Raises:
        ShapeError: an angle in the message is not finite, or a range limit is NaN, so nothing can be drawn.
    """
    for name in ("angle_min", "angle_increment", "range_min", "range_max"):
        value = getattr(scan, name)
        if math.isnan(value) or (name.startswith("angle") and math.isinf(value)):
            raise ShapeError(f"{name} is {value}")
    ranges = np.asarray(scan.ranges, np.float32)
    intensities = np.asarray(scan.intensities, np.float32)[: len(ranges)]
    has_intensities = len(intensities) > 0
    intensities = np.pad(intensities, (0, len(ranges) - len(intensities)))
    description = {
        "kind": "scan",
        "start": _none_if_not_finite(scan.angle_min),
        "step": _none_if_not_finite(scan.angle_increment),
        "least": _none_if_not_finite(scan.range_min),
        "most": _none_if_not_finite(scan.range_max),
        "count": len(ranges),
        "intensities": has_intensities,
    }
    return description, ranges.tobytes() + (intensities.tobytes() if has_intensities else b"")


def occupancy_grid(grid: Any) -> Shape:
    """Return the shape for a map: its cells as int8, row by row from the origin. As in rviz, missing cells are unknown.

    Raises:
        ShapeError: there are too many cells, or the map's origin or resolution is not finite.
    """
    info = grid.info
    count = info.width * info.height
    if count > MAX_CELLS:
        raise ShapeError(f"a map of {info.width} x {info.height} cells is too large to be drawn")
    if not math.isfinite(info.resolution) or (count and not info.resolution):
        raise ShapeError(f"the map's resolution is {info.resolution}")
    if None in (origin := _pose_values(info.origin)):
        raise ShapeError("the map's origin is not finite")
    cells = np.asarray(grid.data, np.int8)
    description: dict[str, Any] = {
        "kind": "map",
        "width": info.width,
        "height": info.height,
        "resolution": _none_if_not_finite(info.resolution),
        "origin": origin,
    }
    if len(cells) != count:
        description["odd"] = f"a map of {info.width} x {info.height} cells has {len(cells)} values"
        cells = np.concatenate([cells[:count], np.full(max(0, count - len(cells)), _UNKNOWN, np.int8)])
    return description, cells.tobytes()


def path(message: Any) -> Shape:
    """Return the shape for a path: its poses as float32 x, y, z, and a quaternion x, y, z, w."""
    return _pose_shape("path", [each.pose for each in message.poses[:MAX_POSES]])


def pose_array(message: Any) -> Shape:
    """Return the shape for several poses, like `path`; poses that are not finite are omitted, and counted in "odd"."""
    return _pose_shape("poses", message.poses[:MAX_POSES], needs_orientation=True)


def pose_stamped(message: Any) -> Shape:
    """Return the shape for a pose, like `pose_array`."""
    return _pose_shape("poses", [message.pose], needs_orientation=True)


def pose_with_covariance(message: Any) -> Shape:
    """Return the shape for a pose, like `pose_array`, with the ellipsoid of its covariance; see `_ellipsoid`."""
    description, blob = _pose_shape("poses", [message.pose.pose], needs_orientation=True)
    return {**description, **_ellipsoid(message.pose.covariance)}, blob


def point_stamped(message: Any) -> Shape:
    """Return the shape for a point."""
    point = message.point
    return {"kind": "point", "point": [_none_if_not_finite(value) for value in (point.x, point.y, point.z)]}, b""


def range_(message: Any) -> Shape:
    """Return the shape for a measured range: the length of a cone, and its full angle.

    A fixed-distance ranger has the same minimum and maximum range; -inf means that an object was detected (REP 117).
    """
    detects_object = message.min_range == message.max_range and message.range == -math.inf
    description = {
        "kind": "range",
        "range": _none_if_not_finite(message.min_range if detects_object else message.range),
        "angle": _none_if_not_finite(message.field_of_view),
        "inside": detects_object or message.min_range <= message.range <= message.max_range,
    }
    return description, b""


def imu(message: Any) -> Shape:
    """Return the shape for an IMU's data: the orientation and the linear acceleration."""
    orientation, acceleration = message.orientation, message.linear_acceleration
    description = {
        "kind": "imu",
        "orientation": [
            _none_if_not_finite(value) for value in (orientation.x, orientation.y, orientation.z, orientation.w)
        ],
        "acceleration": [_none_if_not_finite(value) for value in (acceleration.x, acceleration.y, acceleration.z)],
    }
    return description, b""


def polygon(message: Any) -> Shape:
    """Return the shape for a polygon: its corners as float32 x, y, z."""
    corners = _finite_rows([(point.x, point.y, point.z) for point in message.polygon.points[:MAX_POSES]], 3)
    return {"kind": "polygon", "count": len(corners)}, corners.tobytes()


def grid_cells(message: Any) -> Shape:
    """Return the shape for a list of grid cells: their size, and their centres as float32 x, y, z."""
    centres = _finite_rows([(cell.x, cell.y, cell.z) for cell in message.cells[:MAX_POSES]], 3)
    description = {"kind": "cells", "count": len(centres), "more": len(message.cells) - len(centres)}
    return {
        **description,
        "size": [_none_if_not_finite(message.cell_width), _none_if_not_finite(message.cell_height)],
    }, centres.tobytes()


def wrench(message: Any) -> Shape:
    """Return the shape for a force and a torque."""
    return _linear_and_angular(message.wrench.force, message.wrench.torque, "N", "N m")


def twist(message: Any) -> Shape:
    """Return the shape for a linear and an angular velocity."""
    return _linear_and_angular(message.twist.linear, message.twist.angular, "m/s", "rad/s")


def accel(message: Any) -> Shape:
    """Return the shape for a linear and an angular acceleration."""
    return _linear_and_angular(message.accel.linear, message.accel.angular, "m/s\u00b2", "rad/s\u00b2")


def joint_efforts(message: Any) -> Shape:
    """Return the shape for joint states: "names" and "efforts" (N or N m) of the joints that have an effort."""
    pairs = [(name, _none_if_not_finite(value)) for name, value in zip(message.name, message.effort, strict=False)][
        :MAX_JOINTS
    ]
    joints_with_effort = [(name[:200], value) for name, value in pairs if value is not None]
    description = {
        "kind": "efforts",
        "names": [name for name, _ in joints_with_effort],
        "efforts": [value for _, value in joints_with_effort],
    }
    return description, b""


def _linear_and_angular(linear: Any, angular: Any, linear_unit: str, angular_unit: str) -> Shape:
    description = {
        "kind": "screw",
        "straight": [_none_if_not_finite(value) for value in (linear.x, linear.y, linear.z)],
        "around": [_none_if_not_finite(value) for value in (angular.x, angular.y, angular.z)],
        "units": [linear_unit, angular_unit],
    }
    return description, b""


def _scalar_shape(
    field: str, unit: str, min_value: float, max_value: float, warm: bool = False
) -> Callable[[Any], Shape]:
    """Return a function that returns the shape for a message with one number: a point whose colour shows the number.

    The two bounds of the colour scale are rviz's. As in rviz, red is the colour of the minimum or, for temperatures
    (``warm``), of the maximum.
    """

    def shape(message: Any) -> Shape:
        value = _none_if_not_finite(getattr(message, field))
        return {
            "kind": "measured",
            "value": value,
            "unit": unit,
            "least": min_value,
            "most": max_value,
            "warm": warm,
        }, b""

    return shape


SHAPE_FUNCTIONS: dict[str, Callable[[Any], Shape]] = {
    "geometry_msgs/AccelStamped": accel,
    "geometry_msgs/PointStamped": point_stamped,
    "geometry_msgs/PolygonStamped": polygon,
    "geometry_msgs/PoseArray": pose_array,
    "geometry_msgs/PoseStamped": pose_stamped,
    "geometry_msgs/PoseWithCovarianceStamped": pose_with_covariance,
    "geometry_msgs/TwistStamped": twist,
    "geometry_msgs/WrenchStamped": wrench,
    "nav_msgs/GridCells": grid_cells,
    "nav_msgs/OccupancyGrid": occupancy_grid,
    "nav_msgs/Odometry": pose_with_covariance,
    "nav_msgs/Path": path,
    "sensor_msgs/FluidPressure": _scalar_shape("fluid_pressure", "Pa", 98_000.0, 105_000.0),
    "sensor_msgs/Illuminance": _scalar_shape("illuminance", "lx", 0.0, 1_000.0),
    "sensor_msgs/Imu": imu,
    "sensor_msgs/JointState": joint_efforts,
    "sensor_msgs/LaserScan": laser_scan,
    "sensor_msgs/PointCloud": point_cloud,
    "sensor_msgs/PointCloud2": point_cloud2,
    "sensor_msgs/Range": range_,
    "sensor_msgs/RelativeHumidity": _scalar_shape("relative_humidity", "", 0.0, 1.0),
    "sensor_msgs/Temperature": _scalar_shape("temperature", "\u00b0C", 0.0, 100.0, warm=True),
}
"""Message type -> function that returns the shape for a message. For these types, only the newest message is drawn."""
POSELESS_TYPES = frozenset({"sensor_msgs/JointState"})
"""Types whose messages have no pose in the scene, since their headers usually have no frame."""
CLOUD_FUNCTIONS: dict[str, Callable[[Any, str, int, bool, Bounds | None], Shape]] = {
    "sensor_msgs/PointCloud": point_cloud,
    "sensor_msgs/PointCloud2": point_cloud2,
}
"""Message type -> function for clouds, whose points can be coloured by any field; see `point_cloud2`."""


def _ellipsoid(covariance: Any) -> dict[str, Any]:
    """Return the one-sigma ellipsoid of a position as "spread" (its semi-axes, as three vectors in metres), and "turn".

    "turn" is the standard deviation of yaw in radians. If the covariance is unknown or invalid, the result is empty.
    """
    matrix = np.asarray(covariance, float).reshape(6, 6)
    if not (np.abs(matrix) < MAX_MAGNITUDE).all() or not matrix[:3, :3].any():
        return {}
    with np.errstate(all="ignore"):
        variances, axes = np.linalg.eigh((matrix[:3, :3] + matrix[:3, :3].T) / 2)
    semi_axes = axes * np.sqrt(np.maximum(variances, 0))
    if not (np.abs(semi_axes) < MAX_MAGNITUDE).all():
        return {}
    return {"spread": semi_axes.T.tolist(), "turn": math.sqrt(max(0.0, float(matrix[5, 5])))}


def _finite_rows(rows: Sequence[tuple[float, ...]], size: int, num_required: int = 3) -> NDArray[np.float32]:
    """Return rows of ``size`` numbers as an array; rows whose first ``num_required`` are not all finite are omitted."""
    all_rows = np.array(rows, float).reshape(-1, size)
    valid = np.abs(all_rows) < MAX_MAGNITUDE
    numbers: NDArray[np.float32] = np.where(valid, all_rows, 0)[valid[:, :num_required].all(axis=1)].astype(np.float32)
    return numbers


def _pose_values(pose: Any) -> list[float | None]:
    position, orientation = pose.position, pose.orientation
    return [
        _none_if_not_finite(value)
        for value in (position.x, position.y, position.z, orientation.x, orientation.y, orientation.z, orientation.w)
    ]


def _pose_shape(kind: str, poses: list[Any], needs_orientation: bool = False) -> Shape:
    rows = [
        (position.x, position.y, position.z, orientation.x, orientation.y, orientation.z, orientation.w)
        for position, orientation in ((pose.position, pose.orientation) for pose in poses)
    ]
    valid_rows = _finite_rows(rows, 7, 7 if needs_orientation else 3)
    description = {"kind": kind, "count": len(valid_rows)}
    num_omitted = len(rows) - len(valid_rows)
    return {
        **description,
        **({"odd": f"{num_omitted} of {len(rows)} omitted: not finite"} if num_omitted else {}),
    }, valid_rows.tobytes()


def _none_if_not_finite(value: float) -> float | None:
    return value if abs(value) < MAX_MAGNITUDE else None
