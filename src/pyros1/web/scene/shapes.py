"""Messages as shapes: numbers in one block, and what they mean. Pure but for numpy.

A shape is JSON and bytes. Positions are in metres in the frame of the message's header, angles in radians.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from pyros1.ground.errors import Error

MOST_POINTS = 1_500_000
"""Most points of a cloud that are sent; of larger ones every second, third ... point."""
MOST_POSES = 20_000
MOST_CELLS = 64 << 20
Shape = tuple[dict[str, Any], bytes]


class ShapeError(Error):
    """A message cannot be drawn; the text says why."""


def laser_scan(scan: Any) -> Shape:
    """Return the ranges, and then the intensities if there are as many, as float32."""
    ranges = np.asarray(scan.ranges, np.float32)
    intensities = np.asarray(scan.intensities, np.float32)
    both = len(intensities) == len(ranges)
    facts = {
        "kind": "scan",
        "start": _finite(scan.angle_min),
        "step": _finite(scan.angle_increment),
        "least": _finite(scan.range_min),
        "most": _finite(scan.range_max),
        "count": len(ranges),
        "intensities": both,
    }
    return facts, ranges.tobytes() + (intensities.tobytes() if both else b"")


def point_cloud(cloud: Any) -> Shape:
    """Return the points as they are in the message, or every n-th of them if there are too many.

    Raises:
        ShapeError: the sizes in the message contradict each other, or it has no x, y and z.
    """
    width, height, step, row = cloud.width, cloud.height, cloud.point_step, cloud.row_step
    fields = {field.name: [field.offset, field.datatype, field.count] for field in cloud.fields}
    if not {"x", "y", "z"} <= fields.keys():
        raise ShapeError(f"a cloud without x, y and z; it has {', '.join(fields) or 'no fields'}")
    if step < 1 or row < width * step or len(cloud.data) < (row * (height - 1) + width * step if height else 0):
        raise ShapeError(f"{width} x {height} points of {step} bytes do not fit into {len(cloud.data)} bytes")
    if any(offset + _SIZES.get(kind, 8) > step for offset, kind, _ in fields.values()):
        raise ShapeError(f"a field ends behind its point, which has {step} bytes")
    data = np.frombuffer(cloud.data, np.uint8)
    if height > 1 and row != width * step:
        data = data[: row * height] if len(data) >= row * height else np.pad(data, (0, row * height - len(data)))
        data = data.reshape(height, row)[:, : width * step].reshape(-1)
    points = data[: width * height * step].reshape(-1, step)
    every = -(-len(points) // MOST_POINTS) or 1
    points = points[::every]
    facts = {
        "kind": "cloud",
        "count": len(points),
        "step": step,
        "fields": fields,
        "bigendian": bool(cloud.is_bigendian),
        "every": every,
    }
    return facts, points.tobytes()


_SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 8: 8}
"""Bytes of the types of sensor_msgs/PointField."""


def occupancy_grid(grid: Any) -> Shape:
    """Return the cells as int8, row by row from the origin.

    Raises:
        ShapeError: the number of cells is wrong, or too large.
    """
    info = grid.info
    count = info.width * info.height
    if count > MOST_CELLS:
        raise ShapeError(f"a map of {info.width} x {info.height} cells is too large to be drawn")
    if len(grid.data) != count:
        raise ShapeError(f"a map of {info.width} x {info.height} cells has {len(grid.data)} values")
    facts = {
        "kind": "map",
        "width": info.width,
        "height": info.height,
        "resolution": _finite(info.resolution),
        "origin": _pose(info.origin),
    }
    return facts, np.asarray(grid.data, np.int8).tobytes()


def path(message: Any) -> Shape:
    """Return the poses as float32: x, y, z, and a quaternion x, y, z, w."""
    poses = [each.pose for each in message.poses[:MOST_POSES]]
    return {"kind": "path", "count": len(poses)}, _poses(poses)


def pose_array(message: Any) -> Shape:
    """Return the poses as for `path`."""
    poses = message.poses[:MOST_POSES]
    return {"kind": "poses", "count": len(poses)}, _poses(poses)


def pose_stamped(message: Any) -> Shape:
    """Return the pose as for `path`."""
    return {"kind": "poses", "count": 1}, _poses([message.pose])


def pose_with_covariance(message: Any) -> Shape:
    """Return the pose as for `path`, with its covariance of 6 x 6."""
    covariance = [_finite(value) for value in message.pose.covariance]
    return {"kind": "poses", "count": 1, "covariance": covariance}, _poses([message.pose.pose])


def point_stamped(message: Any) -> Shape:
    """Return the point."""
    point = message.point
    return {"kind": "point", "point": [_finite(value) for value in (point.x, point.y, point.z)]}, b""


def range_(message: Any) -> Shape:
    """Return a cone: its length and its whole angle."""
    facts = {
        "kind": "range",
        "range": _finite(message.range),
        "angle": _finite(message.field_of_view),
        "inside": message.min_range <= message.range <= message.max_range,
    }
    return facts, b""


def imu(message: Any) -> Shape:
    """Return orientation and linear acceleration."""
    turn, push = message.orientation, message.linear_acceleration
    facts = {
        "kind": "imu",
        "orientation": [_finite(value) for value in (turn.x, turn.y, turn.z, turn.w)],
        "acceleration": [_finite(value) for value in (push.x, push.y, push.z)],
    }
    return facts, b""


SHAPES: dict[str, Callable[[Any], Shape]] = {
    "geometry_msgs/PointStamped": point_stamped,
    "geometry_msgs/PoseArray": pose_array,
    "geometry_msgs/PoseStamped": pose_stamped,
    "geometry_msgs/PoseWithCovarianceStamped": pose_with_covariance,
    "nav_msgs/OccupancyGrid": occupancy_grid,
    "nav_msgs/Odometry": pose_with_covariance,
    "nav_msgs/Path": path,
    "sensor_msgs/Imu": imu,
    "sensor_msgs/LaserScan": laser_scan,
    "sensor_msgs/PointCloud2": point_cloud,
    "sensor_msgs/Range": range_,
}
"""Types that can be drawn from their newest message alone."""


def _pose(pose: Any) -> list[float | None]:
    place, turn = pose.position, pose.orientation
    return [_finite(value) for value in (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)]


def _poses(poses: list[Any]) -> bytes:
    numbers = [
        number
        for pose in poses
        for place, turn in ((pose.position, pose.orientation),)
        for number in (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)
    ]
    with np.errstate(over="ignore"):
        return np.array(numbers, np.float32).tobytes()


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
