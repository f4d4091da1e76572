"""Rotations as quaternions (x, y, z, w) of floats, which are faster than numpy for a single rotation.

`pyros1.tf.rotation` has transforms; this module has the functions that orientation filters need.
"""

from __future__ import annotations

from math import cos, hypot, sin, sqrt

from pyros1.tf.rotation import Quaternion, Vector


def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """Return the product of two quaternions; as a rotation, it applies ``second`` before ``first``."""
    ax, ay, az, aw = first
    bx, by, bz, bw = second
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def conjugate(rotation: Quaternion) -> Quaternion:
    """Return the inverse of a rotation."""
    x, y, z, w = rotation
    return -x, -y, -z, w


def rotate(rotation: Quaternion, vector: Vector) -> Vector:
    """Return a vector, rotated by a quaternion of unit length."""
    x, y, z, w = rotation
    vx, vy, vz = vector
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx


def normalized(rotation: Quaternion) -> Quaternion:
    """Return a quaternion scaled to unit length.

    Raises:
        ZeroDivisionError: its length is 0.
    """
    x, y, z, w = rotation
    scale = 1.0 / hypot(x, y, z, w)
    return x * scale, y * scale, z * scale, w * scale


def from_rotation_vector(x: float, y: float, z: float) -> Quaternion:
    """Return the rotation about an axis by an angle in radians, given as the axis times the angle."""
    angle = hypot(x, y, z)
    scale = sin(angle / 2.0) / angle if angle > 0.0 else 0.5
    return x * scale, y * scale, z * scale, cos(angle / 2.0)


def from_rows(first: Vector, second: Vector, third: Vector) -> Quaternion:
    """Return the quaternion of a rotation matrix, given as its rows."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = first, second, third
    # Four times the square of each component. The result is divided by the largest one, since the others may be 0.
    squares = 1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz, 1.0 + xx + yy + zz
    largest = max(range(4), key=squares.__getitem__)
    products = (
        (squares[0], xy + yx, xz + zx, zy - yz),
        (xy + yx, squares[1], yz + zy, xz - zx),
        (xz + zx, yz + zy, squares[2], yx - xy),
        (zy - yz, xz - zx, yx - xy, squares[3]),
    )[largest]
    scale = 0.5 / sqrt(squares[largest])
    return normalized((products[0] * scale, products[1] * scale, products[2] * scale, products[3] * scale))
