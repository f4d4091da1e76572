"""Rotation matrices and quaternions computed as PyKDL does: quaternions are not normalized.

Matrices and quaternions are tuples of floats, since numpy is slower for so few numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Any

Row = tuple[float, float, float]
Matrix = tuple[Row, Row, Row]

_MIN_TRACE = 1e-6


def from_quaternion(x: float, y: float, z: float, w: float) -> Matrix:
    """Return the matrix (3, 3) of a quaternion."""
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    return (
        (ww + xx - yy - zz, 2 * x * y - 2 * w * z, 2 * x * z + 2 * w * y),
        (2 * x * y + 2 * w * z, ww - xx + yy - zz, 2 * y * z - 2 * w * x),
        (2 * x * z - 2 * w * y, 2 * y * z + 2 * w * x, ww - xx - yy + zz),
    )


def to_quaternion(matrix: Matrix) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of a matrix (3, 3): with a positive w or, if w is small, a positive largest
    component.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix
    trace = xx + yy + zz
    if trace > _MIN_TRACE:
        s = 0.5 / sqrt(trace + 1.0)
        return (zy - yz) * s, (xz - zx) * s, (yx - xy) * s, 0.25 / s
    if xx > yy and xx > zz:
        s = 2.0 * sqrt(1.0 + xx - yy - zz)
        return 0.25 * s, (xy + yx) / s, (xz + zx) / s, (zy - yz) / s
    if yy > zz:
        s = 2.0 * sqrt(1.0 + yy - xx - zz)
        return (xy + yx) / s, 0.25 * s, (yz + zy) / s, (xz - zx) / s
    s = 2.0 * sqrt(1.0 + zz - xx - yy)
    return (xz + zx) / s, (yz + zy) / s, 0.25 * s, (yx - xy) / s


def multiply(left: Matrix, right: Matrix) -> Matrix:
    """Return the product of two 3x3 matrices."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (rotate(left, column) for column in zip(*right, strict=True))
    return (ax, bx, cx), (ay, by, cy), (az, bz, cz)


def rotate(rotation: Matrix, vector: Sequence[float]) -> Row:
    """Return a rotated vector (3,)."""
    x, y, z = vector
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    return xx * x + xy * y + xz * z, yx * x + yy * y + yz * z, zx * x + zy * y + zz * z


def transform_point(transform: Any, point: Row) -> Row:
    """Return a point (3,), transformed by a geometry_msgs/Transform."""
    q, v = transform.rotation, transform.translation
    x, y, z = rotate(from_quaternion(q.x, q.y, q.z, q.w), point)
    return x + v.x, y + v.y, z + v.z
