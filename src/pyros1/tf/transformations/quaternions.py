"""Rotations as quaternions [x, y, z, w]; see `pyros1.tf.transformations`."""

from __future__ import annotations

from math import acos, cos, pi, sin, sqrt

import numpy as np
from numpy.typing import ArrayLike

from pyros1.tf.rotation import EPS
from pyros1.tf.transformations.vectors import Array, float_array, unit_vector


def quaternion_multiply(quaternion1: ArrayLike, quaternion0: ArrayLike) -> Array:
    """Return ``quaternion1`` (4,) times ``quaternion0`` (4,), the rotation (4,) that applies ``quaternion0`` first."""
    x1, y1, z1, w1 = float_array(quaternion1).tolist()  # for single numbers, floats are faster than numpy
    x0, y0, z0, w0 = float_array(quaternion0).tolist()
    return np.array(
        (
            w1 * x0 + x1 * w0 + y1 * z0 - z1 * y0,
            w1 * y0 + y1 * w0 + z1 * x0 - x1 * z0,
            w1 * z0 + z1 * w0 + x1 * y0 - y1 * x0,
            w1 * w0 - x1 * x0 - y1 * y0 - z1 * z0,
        )
    )


def quaternion_conjugate(quaternion: ArrayLike) -> Array:
    """Return the conjugate (4,) of a quaternion (4,); if the quaternion has unit length, that is its inverse."""
    return float_array(quaternion, 4) * (-1.0, -1.0, -1.0, 1.0)


def quaternion_inverse(quaternion: ArrayLike) -> Array:
    """Return the inverse (4,) of a quaternion (4,): their product is [0, 0, 0, 1]."""
    q = float_array(quaternion, 4)
    return quaternion_conjugate(q) / (q @ q)


def quaternion_about_axis(angle: float, axis: ArrayLike) -> Array:
    """Return the quaternion (4,) of a rotation by an angle in radians about an axis (3,) of any length."""
    x, y, z = float_array(axis, 3).tolist()
    length = sqrt(x * x + y * y + z * z)
    scale = 1.0 if length <= EPS else sin(angle / 2.0) / length
    return np.array((x * scale, y * scale, z * scale, cos(angle / 2.0)))


def quaternion_slerp(
    quat0: ArrayLike, quat1: ArrayLike, fraction: float, spin: int = 0, shortestpath: bool = True
) -> Array:
    """Return the quaternion (4,) between two rotations, interpolated at constant angular velocity.

    Args:
        quat0: the first rotation (4,), of any length.
        quat1: the last rotation (4,), of any length.
        fraction: 0 for ``quat0``, 1 for ``quat1``.
        spin: additional half turns.
        shortestpath: whether to take the nearer of ``quat1`` and its negative, which is the same rotation.
    """
    start, end = unit_vector(float_array(quat0, 4)), unit_vector(float_array(quat1, 4))
    if fraction in (0.0, 1.0):
        return end if fraction else start
    cosine = float(start @ end)
    if abs(abs(cosine) - 1.0) < EPS:
        return start
    if shortestpath and cosine < 0.0:
        cosine, end = -cosine, -end
    angle = acos(cosine) + spin * pi
    if abs(angle) < EPS:
        return start
    result: Array = (sin((1.0 - fraction) * angle) * start + sin(fraction * angle) * end) / sin(angle)
    return result


def random_quaternion(rand: ArrayLike | None = None) -> Array:
    """Return a random unit quaternion (4,); all rotations are equally likely.

    Args:
        rand: three numbers from 0 to 1 (3,) that determine the result; None for random numbers.
    """
    a, b, c = np.random.rand(3) if rand is None else float_array(rand)
    radius1, radius2, b, c = np.sqrt(1.0 - a), np.sqrt(a), 2.0 * pi * b, 2.0 * pi * c
    return np.array((sin(b) * radius1, cos(b) * radius1, sin(c) * radius2, cos(c) * radius2))


def quaternion_matrix(quaternion: ArrayLike) -> Array:
    """Return the rotation matrix (4, 4) of a quaternion (4,) of any length; the identity for length 0."""
    x, y, z, w = float_array(quaternion, 4).tolist()
    square = x * x + y * y + z * z + w * w
    if square < EPS:
        return np.identity(4)
    s = 2.0 / square
    return np.array(
        (
            (1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), 0.0),
            (s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w), 0.0),
            (s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y), 0.0),
            (0.0, 0.0, 0.0, 1.0),
        )
    )


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """Return the unit quaternion (4,) of the rotation in a matrix (4, 4).

    For rotations by less than 120 degrees, w is positive; for others, the largest of x, y and z is positive.
    """
    m = np.asarray(matrix, np.float64).tolist()  # for single numbers, floats are faster than numpy
    factor, trace = m[3][3], m[0][0] + m[1][1] + m[2][2]
    # The quaternion, multiplied by four times one of its components.
    if trace > 0.0:
        square = factor + trace
        products = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], square]
    else:
        i = max(range(3), key=lambda part: m[part][part])
        j, k = (i + 1) % 3, (i + 2) % 3
        square = factor + m[i][i] - m[j][j] - m[k][k]
        products = [m[i][part] + m[part][i] for part in range(3)] + [m[k][j] - m[j][k]]
        products[i] = square
    scale = 0.5 / sqrt(square * factor)
    return np.array([product * scale for product in products])
