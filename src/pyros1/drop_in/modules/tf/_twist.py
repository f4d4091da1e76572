"""The mean velocity of one frame in another over an interval.

The angular velocity is the same as in stock ROS. The linear velocity is the velocity of a point that moves with the
frame; stock's Python code computes something that is not a velocity.
"""

from __future__ import annotations

from typing import Any

import numpy
import rospy

from tf import transformations


def mean_twist(
    transformer: Any,
    tracking: str,
    observation: str,
    reference: str,
    point: Any,
    point_frame: str,
    time: Any,
    interval: Any,
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return linear and angular velocity; see `tf.Transformer.lookupTwistFull`."""
    latest = transformer.getLatestCommonTime(observation, tracking)
    middle = latest if time == rospy.Time() else time
    end = min(middle + rospy.Duration(interval.to_sec() * 0.5), latest)
    start = max(rospy.Time(0.00001) + interval, end) - interval
    seconds = (end - start).to_sec()

    start_position, start_rotation = _lookup(transformer, observation, tracking, start)
    end_position, end_rotation = _lookup(transformer, observation, tracking, end)
    relative_rotation = transformations.quaternion_multiply(
        transformations.quaternion_inverse(start_rotation), end_rotation
    )
    angle, axis = _angle_and_axis(relative_rotation)
    linear = (end_position - start_position) / seconds

    origin, rotation = _lookup(transformer, reference, tracking, middle)
    angular = _rotate(rotation, axis) * (angle / seconds)
    _, rotation = _lookup(transformer, reference, observation, middle)
    position, point_rotation = _lookup(transformer, reference, point_frame, middle)
    xyz = (point.x, point.y, point.z) if hasattr(point, "x") else tuple(point)
    lever_arm = _rotate(point_rotation, xyz) + position - origin
    linear = _rotate(rotation, linear) + numpy.cross(angular, lever_arm)
    return tuple(linear.tolist()), tuple(angular.tolist())


def _lookup(transformer: Any, target: str, source: str, time: Any) -> tuple[Any, Any]:
    position, rotation = transformer.lookupTransform(target, source, time)
    return numpy.array(position), numpy.array(rotation)


def _angle_and_axis(quaternion: Any) -> tuple[float, Any]:
    x, y, z, w = quaternion if quaternion[3] >= 0 else -quaternion  # the rotation by at most half a turn
    sine = numpy.sqrt(x * x + y * y + z * z)
    if sine < 1e-12:
        return 0.0, numpy.array((1.0, 0.0, 0.0))
    return 2.0 * float(numpy.arctan2(sine, w)), numpy.array((x, y, z)) / sine


def _rotate(quaternion: Any, vector: Any) -> Any:
    return transformations.quaternion_matrix(quaternion)[:3, :3] @ numpy.asarray(vector, numpy.float64)
