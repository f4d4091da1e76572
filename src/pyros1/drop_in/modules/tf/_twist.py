"""How a frame moves in another: the calculation of stock's lookupTwist, with its peculiarities.

It takes the mean velocity over an interval. What it says of frames that rotate or are apart is not a velocity in the
sense of mechanics: the vector is rotated once too often. Programs rely on its numbers.
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
    axis = _rotated(start_turn, axis)
    linear = [(after - before) / seconds for before, after in zip(start_place, end_place, strict=True)]
    angular = axis * (angle / seconds)

    place, turn = _lookup(transformer, reference, tracking, middle)
    angular = _rotated(turn, angular)
    linear = _rotated(turn, linear) + numpy.cross(place, angular)
    origin = place
    place, turn = _lookup(transformer, reference, point_frame, middle)
    xyz = (point.x, point.y, point.z) if hasattr(point, "x") else tuple(point)
    linear = linear + numpy.cross(angular, _rotated(turn, xyz) + place - origin)
    return tuple(linear.tolist()), tuple(angular.tolist())


def _lookup(transformer: Any, target: str, source: str, time: Any) -> tuple[Any, Any]:
    place, turn = transformer.lookupTransform(target, source, time)
    return numpy.array(place), numpy.array(turn)


def _angle_and_axis(quaternion: Any) -> tuple[float, Any]:
    x, y, z, w = quaternion
    sine = numpy.sqrt(x * x + y * y + z * z)
    if sine < 1e-12:
        return 0.0, numpy.array((1.0, 0.0, 0.0))
    return 2.0 * float(numpy.arctan2(sine, w)), numpy.array((x, y, z)) / sine


def _rotated(quaternion: Any, vector: Any) -> Any:
    return transformations.quaternion_matrix(quaternion)[:3, :3] @ numpy.asarray(vector, numpy.float64)
