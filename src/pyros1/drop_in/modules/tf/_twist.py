"""The velocity of a frame in another one, as a mean over an interval.

The angular velocity is the same as in stock. The linear one is that of a point which moves with the frame; the result
of stock's Python code is not a velocity.
"""

from __future__ import annotations

from typing import Any

import numpy
import rospy

from tf import transformations


def twist(
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

    start_place, start_turn = _lookup(transformer, observation, tracking, start)
    end_place, end_turn = _lookup(transformer, observation, tracking, end)
    between = transformations.quaternion_multiply(transformations.quaternion_inverse(start_turn), end_turn)
    angle, axis = _angle_and_axis(between)
    linear = (end_place - start_place) / seconds

    origin, turn = _lookup(transformer, reference, tracking, middle)
    angular = _rotated(turn, axis) * (angle / seconds)
    _, turn = _lookup(transformer, reference, observation, middle)
    place, point_turn = _lookup(transformer, reference, point_frame, middle)
    xyz = (point.x, point.y, point.z) if hasattr(point, "x") else tuple(point)
    arm = _rotated(point_turn, xyz) + place - origin
    linear = _rotated(turn, linear) + numpy.cross(angular, arm)
    return tuple(linear.tolist()), tuple(angular.tolist())


def _lookup(transformer: Any, target: str, source: str, time: Any) -> tuple[Any, Any]:
    place, turn = transformer.lookupTransform(target, source, time)
    return numpy.array(place), numpy.array(turn)


def _angle_and_axis(quaternion: Any) -> tuple[float, Any]:
    x, y, z, w = quaternion if quaternion[3] >= 0 else -quaternion  # the rotation by at most half a turn
    sine = numpy.sqrt(x * x + y * y + z * z)
    if sine < 1e-12:
        return 0.0, numpy.array((1.0, 0.0, 0.0))
    return 2.0 * float(numpy.arctan2(sine, w)), numpy.array((x, y, z)) / sine


def _rotated(quaternion: Any, vector: Any) -> Any:
    return transformations.quaternion_matrix(quaternion)[:3, :3] @ numpy.asarray(vector, numpy.float64)
