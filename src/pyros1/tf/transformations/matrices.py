"""Creates and multiplies homogeneous matrices; see `pyros1.tf.transformations`."""

from __future__ import annotations

from functools import reduce
from math import sqrt, tan

import numpy as np
from numpy.typing import ArrayLike

from pyros1.tf.rotation import EPS
from pyros1.tf.transformations.angles import euler_matrix
from pyros1.tf.transformations.quaternions import quaternion_about_axis, quaternion_matrix, random_quaternion
from pyros1.tf.transformations.vectors import Array, float_array, unit_vector

_MAX_COSINE = 1e-6
"""Maximum cosine of the angle between directions that count as perpendicular."""


def identity_matrix() -> Array:
    """Return the identity matrix (4, 4)."""
    return np.identity(4)


def translation_matrix(direction: ArrayLike) -> Array:
    """Return the matrix (4, 4) that translates by a vector (3,)."""
    matrix = np.identity(4)
    matrix[:3, 3] = float_array(direction, 3)
    return matrix


def rotation_matrix(angle: float, direction: ArrayLike, point: ArrayLike | None = None) -> Array:
    """Return the matrix (4, 4) that rotates about an axis in a direction (3,), through a point (3,) or the origin."""
    return _about_point(quaternion_matrix(quaternion_about_axis(angle, _unit_direction(direction)))[:3, :3], point)


def random_rotation_matrix(rand: ArrayLike | None = None) -> Array:
    """Return the matrix (4, 4) of a random rotation; see `random_quaternion`."""
    return quaternion_matrix(random_quaternion(rand))


def scale_matrix(factor: float, origin: ArrayLike | None = None, direction: ArrayLike | None = None) -> Array:
    """Return the matrix (4, 4) that scales about a point (3,) or the origin, in one direction (3,) or in all."""
    if direction is None:
        return _about_point(factor * np.identity(3), origin)
    u = _unit_direction(direction)
    return _about_point(np.identity(3) + (factor - 1.0) * np.outer(u, u), origin)


def reflection_matrix(point: ArrayLike, normal: ArrayLike) -> Array:
    """Return the matrix (4, 4) that reflects in the plane through a point (3,), perpendicular to ``normal`` (3,)."""
    return scale_matrix(-1.0, point, normal)


def shear_matrix(angle: float, direction: ArrayLike, point: ArrayLike, normal: ArrayLike) -> Array:
    """Return the matrix (4, 4) that shears by an angle, in a direction, along the plane through a point.

    Args:
        angle: angle in radians by which lines perpendicular to the plane are tilted.
        direction: direction in the plane (3,).
        point: a point in the plane (3,).
        normal: the plane's normal (3,).

    Raises:
        ValueError: the direction and the normal are not perpendicular.
    """
    d, n = _unit_direction(direction), _unit_direction(normal)
    if abs(d @ n) > _MAX_COSINE:
        raise ValueError("the direction must lie in the plane: perpendicular to its normal")
    return _about_point(np.identity(3) + tan(angle) * np.outer(d, n), point)


def projection_matrix(
    point: ArrayLike,
    normal: ArrayLike,
    direction: ArrayLike | None = None,
    perspective: ArrayLike | None = None,
    pseudo: bool = False,
) -> Array:
    """Return the matrix (4, 4) that projects onto the plane through a point.

    Args:
        point: a point in the plane (3,).
        normal: the plane's normal (3,).
        direction: direction of projection (3,), unless ``perspective`` is given; None for the normal's direction.
        perspective: the point (3,) through which all rays pass.
        pseudo: whether to keep the depth behind the plane, so that the result must still be projected along the
            normal.
    """
    n = _unit_direction(normal)
    if perspective is None:
        d = n if direction is None else float_array(direction, 3)
        return _about_point(np.identity(3) - np.outer(d, n) / (d @ n), point)
    p, height = float_array(perspective, 3), float_array(point, 3) @ n
    # For a point x: (distance x - p n.x + height p) / (p.n - x.n); pseudo adds the part outside the plane, along n.
    q = p + n if pseudo else p
    matrix = np.empty((4, 4))
    matrix[:3, :3] = (p @ n - height) * np.identity(3) - np.outer(q, n)
    matrix[:3, 3] = height * q
    matrix[3] = *-n, p @ n
    return matrix


def clip_matrix(
    left: float, right: float, bottom: float, top: float, near: float, far: float, perspective: bool = False
) -> Array:
    """Return the matrix (4, 4) that maps a box, or a frustum seen from the origin, to the cube from -1 to 1.

    Raises:
        ValueError: the box has no volume, or the frustum does not begin in front of the viewer.
    """
    if left >= right or bottom >= top or near >= far:
        raise ValueError("the bounds must be: left < right, bottom < top, near < far")
    if perspective and near <= EPS:
        raise ValueError("a frustum begins in front of the eye: near must be positive")
    low, high = np.array((left, bottom, near)), np.array((right, top, far))
    size, offset = high - low, (low + high) / (high - low)
    matrix = np.diag((*2.0 / size, 1.0))
    matrix[:3, 3] = -offset
    if perspective:
        matrix = np.diag((*-2.0 * near / size, 0.0))
        matrix[:3, 2] = offset * (1.0, 1.0, -1.0)
        matrix[2:, 2:] = (-offset[2], 2.0 * near * far / size[2]), (-1.0, 0.0)
    return matrix


def orthogonalization_matrix(lengths: ArrayLike, angles: ArrayLike) -> Array:
    """Return the matrix (4, 4) that converts a crystal cell's coordinates to perpendicular ones.

    Args:
        lengths: lengths of the cell's edges a, b, c (3,).
        angles: angles in degrees (3,), between b and c, a and c, a and b.

    Raises:
        ValueError: no cell has such angles.
    """
    a, b, c = float_array(lengths)
    alpha, beta, _ = radians = np.radians(angles)
    cos_alpha, cos_beta, cos_gamma = np.cos(radians)
    # c points along z, and b lies in the y-z plane; the components of a follow from a's angles to b and c.
    y = (cos_gamma - cos_alpha * cos_beta) / np.sin(alpha)
    matrix = np.identity(4)
    matrix[:3, 0] = a * sqrt(np.sin(beta) ** 2 - y * y), a * y, a * cos_beta
    matrix[1:3, 1] = b * np.sin(alpha), b * cos_alpha
    matrix[2, 2] = c
    return matrix


def compose_matrix(
    scale: ArrayLike | None = None,
    shear: ArrayLike | None = None,
    angles: ArrayLike | None = None,
    translate: ArrayLike | None = None,
    perspective: ArrayLike | None = None,
) -> Array:
    """Return the matrix (4, 4) that scales, shears, rotates, translates and projects, in this order.

    `decompose_matrix` is the inverse.

    Args:
        scale: factors of x, y, z (3,).
        shear: shear factors of x by y, x by z, y by z (3,).
        angles: roll, pitch and yaw in radians (3,).
        translate: vector of the translation (3,).
        perspective: the matrix's last row (4,).
    """
    matrix = np.identity(4)
    if perspective is not None:
        matrix[3] = float_array(perspective, 4)
    if translate is not None:
        matrix = matrix @ translation_matrix(translate)
    if angles is not None:
        matrix = matrix @ euler_matrix(*float_array(angles, 3).tolist())
    if shear is not None:
        shear_part = np.identity(4)
        shear_part[[0, 0, 1], [1, 2, 2]] = float_array(shear, 3)
        matrix = matrix @ shear_part
    if scale is not None:
        x, y, z = float_array(scale, 3)
        matrix = matrix * (x, y, z, 1.0)
    return np.asarray(matrix / matrix[3, 3])


def superimposition_matrix(v0: ArrayLike, v1: ArrayLike, scaling: bool = False, usesvd: bool = True) -> Array:
    """Return the matrix (4, 4) that best maps points to other points, by rotation, translation and scaling.

    Args:
        v0: x, y and z of the points, as three rows (3, n) with n of at least 3; further rows are ignored.
        v1: the points (3, n) to which the points in ``v0`` are mapped.
        scaling: whether to scale by a common factor as well.
        usesvd: ignored; both of stock's methods give the same result.

    Raises:
        ValueError: ``v0`` and ``v1`` have different shapes, or have fewer than three rows or points.
    """
    start, end = float_array(v0, 3), float_array(v1, 3)
    if start.shape != end.shape or min(start.shape) < 3:
        raise ValueError("v0 and v1 must have the same shape, with at least three rows and three points")
    center0, center1 = start.mean(1), end.mean(1)
    start, end = start - center0[:, None], end - center1[:, None]
    left, _, right = np.linalg.svd(end @ start.T)  # W. Kabsch, 1976
    left[:, 2] *= np.sign(np.linalg.det(left @ right))  # makes the product a rotation, not a reflection
    linear = left @ right
    if scaling:
        linear *= np.linalg.norm(end) / np.linalg.norm(start)
    matrix = _about_point(linear, None)
    matrix[:3, 3] = center1 - linear @ center0
    return matrix


def concatenate_matrices(*matrices: ArrayLike) -> Array:
    """Return the product (4, 4) of matrices (4, 4); the last one is applied first."""
    return reduce(np.dot, matrices, np.identity(4))


def inverse_matrix(matrix: ArrayLike) -> Array:
    """Return the inverse (n, n) of a matrix (n, n).

    Raises:
        numpy.linalg.LinAlgError: the matrix is singular.
    """
    return np.linalg.inv(np.asarray(matrix, np.float64))


def is_same_transform(matrix0: ArrayLike, matrix1: ArrayLike) -> bool:
    """Return whether two matrices (4, 4) are equal up to a common factor."""
    m0, m1 = np.asarray(matrix0, np.float64), np.asarray(matrix1, np.float64)
    return np.allclose(m0 / m0[3, 3], m1 / m1[3, 3])


def _unit_direction(direction: ArrayLike) -> Array:
    return unit_vector(float_array(direction, 3))


def _about_point(linear: Array, point: ArrayLike | None) -> Array:
    """Return the matrix (4, 4) that acts about a point (3,) as ``linear`` (3, 3) does about the origin."""
    matrix = np.identity(4)
    matrix[:3, :3] = linear
    if point is not None:
        p = float_array(point, 3)
        matrix[:3, 3] = p - linear @ p
    return matrix
