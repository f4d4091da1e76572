"""Quaternions and rigid transforms as tuples, with tf2's order of operations, so that results agree to the last bits.

A quaternion is (x, y, z, w), a transform (x, y, z, qx, qy, qz, qw). Quaternions need not have unit length: tf2 accepts
deviations of up to half a percent without normalising, and so does this module. It uses floats, since numpy is slower
for so few numbers and takes a tenth of a second to import; `pyros1.tf.transformations` uses numpy.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, sin, sqrt

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Transform = tuple[float, float, float, float, float, float, float]

EPS = 4 * 2.0**-52
"""Lengths below this are treated as 0."""

IDENTITY: Transform = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def from_angles(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the quaternion of rotations about the fixed axes x, then y, then z, by angles in radians."""
    cr, sr, cp, sp, cy, sy = (part for angle in (roll, pitch, yaw) for part in (cos(angle / 2.0), sin(angle / 2.0)))
    return (
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
        cy * cp * cr + sy * sp * sr,
    )


def to_angles(rotation: Quaternion) -> Vector:
    """Return roll, pitch and yaw in radians; if the pitch is 90 degrees up or down, the yaw is 0."""
    x, y, z, w = rotation
    square = x * x + y * y + z * z + w * w
    # elements of the rotation matrix, times the square of the length
    xx, yx, zx = w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    horizontal = hypot(xx, yx)
    pitch = atan2(-zx, horizontal)
    if horizontal <= EPS * square:
        return atan2(2.0 * (w * x - y * z), w * w - x * x + y * y - z * z), pitch, 0.0
    return atan2(2.0 * (y * z + w * x), w * w - x * x - y * y + z * z), pitch, atan2(yx, xx)


def multiply(first: Transform, second: Transform) -> Transform:
    """Return the product of two transforms: ``first`` (parent <- child) times ``second`` (child <- grandchild)."""
    tx, ty, tz, ax, ay, az, aw = first
    x, y, z, bx, by, bz, bw = second
    # The quaternion of `first` times (x, y, z, 0), but with -w. The result below multiplies it by the conjugate.
    px = aw * x + ay * z - az * y
    py = aw * y + az * x - ax * z
    pz = aw * z + ax * y - ay * x
    pw = ax * x + ay * y + az * z
    return (
        pw * ax + px * aw - py * az + pz * ay + tx,
        pw * ay + py * aw - pz * ax + px * az + ty,
        pw * az + pz * aw - px * ay + py * ax + tz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def product(steps: Sequence[Transform]) -> Transform:
    """Return the product (see `multiply`) of one or more transforms: the last one times ... times the first one."""
    x, y, z, bx, by, bz, bw = steps[0]
    for tx, ty, tz, ax, ay, az, aw in steps[1:]:  # inlined from `multiply`, since calls would take most of the time
        px = aw * x + ay * z - az * y
        py = aw * y + az * x - ax * z
        pz = aw * z + ax * y - ay * x
        pw = ax * x + ay * y + az * z
        x = pw * ax + px * aw - py * az + pz * ay + tx
        y = pw * ay + py * aw - pz * ax + px * az + ty
        z = pw * az + pz * aw - px * ay + py * ax + tz
        qx = aw * bx + ax * bw + ay * bz - az * by
        qy = aw * by + ay * bw + az * bx - ax * bz
        qz = aw * bz + az * bw + ax * by - ay * bx
        bw = aw * bw - ax * bx - ay * by - az * bz
        bx, by, bz = qx, qy, qz
    return (x, y, z, bx, by, bz, bw)


def invert(transform: Transform) -> Transform:
    """Return the inverse of a transform."""
    x, y, z, qx, qy, qz, qw = transform
    inverted = multiply((0.0, 0.0, 0.0, -qx, -qy, -qz, qw), (-x, -y, -z, *IDENTITY[3:]))
    return (inverted[0], inverted[1], inverted[2], -qx, -qy, -qz, qw)


def multiply_normalized(first: Transform, second: Transform) -> Transform:
    """Return the result of `multiply`, but with a normalised quaternion that has the same sign as after conversion to a
    matrix and back.
    """
    x, y, z, *rotation = multiply(_normalized(first), _normalized(second))
    # Conversion from a matrix gives a positive w or, if w is small, a positive largest component.
    largest = 3 if rotation[3] * rotation[3] > 0.25 else max(range(3), key=lambda i: abs(rotation[i]))
    qx, qy, qz, qw = rotation if rotation[largest] >= 0 else [-part for part in rotation]
    return (x, y, z, qx, qy, qz, qw)


def _normalized(transform: Transform) -> Transform:
    x, y, z, qx, qy, qz, qw = transform
    length = sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
    return (x, y, z, qx / length, qy / length, qz / length, qw / length)
