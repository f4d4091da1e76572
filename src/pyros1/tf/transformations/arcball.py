"""Arcball: a sphere on the screen that is rotated with the mouse; see `pyros1.tf.transformations`."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from pyros1.tf.rotation import EPS
from pyros1.tf.transformations.quaternions import (
    quaternion_from_matrix,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
)
from pyros1.tf.transformations.vectors import Array, float_array, unit_vector, vector_norm


class Arcball:
    """A sphere that is rotated by dragging points on it (Shoemake's arcball).

    Args:
        initial: initial rotation, a quaternion (4,) or a matrix (4, 4); None for no rotation.

    Raises:
        ValueError: ``initial`` has a different shape.
    """

    def __init__(self, initial: ArrayLike | None = None) -> None:
        self._center = np.zeros(2)
        self._radius = 1.0
        self._axes: list[Array] | None = None
        self._axis: Array | None = None  # axis of the current drag; None for any
        self._constrain = False
        self._grabbed_point = np.array((0.0, 0.0, 1.0))
        self._start_rotation = self._last_rotation = self._current_rotation = _to_quaternion(initial)

    def place(self, center: ArrayLike, radius: float) -> None:
        """Set the sphere's position on the screen: its center (2,) and its radius, in pixels."""
        self._center = float_array(center, 2).copy()
        self._radius = float(radius)

    def setaxes(self, *axes: ArrayLike) -> None:
        """Set the axes (3,) about which the sphere can rotate while it is constrained; without arguments, it can rotate
        about any axis.
        """
        self._axes = [unit_vector(axis) for axis in axes] if axes else None

    def setconstrain(self, constrain: bool) -> None:
        """Set whether a drag rotates the sphere only about one of its axes: the one nearest to the drag's first
        point.
        """
        self._constrain = constrain is True

    def getconstrain(self) -> bool:
        """Return whether a drag rotates the sphere only about one of its axes."""
        return self._constrain

    def down(self, point: ArrayLike) -> None:
        """Start a drag at a point on the screen (2,)."""
        self._grabbed_point = arcball_map_to_sphere(point, self._center, self._radius)
        self._start_rotation = self._last_rotation = self._current_rotation
        self._axis = None
        if self._constrain and self._axes is not None:
            self._axis = arcball_nearest_axis(self._grabbed_point, self._axes)
            self._grabbed_point = arcball_constrain_to_axis(self._grabbed_point, self._axis)

    def drag(self, point: ArrayLike) -> None:
        """Continue a drag to a point on the screen (2,)."""
        dragged_point = arcball_map_to_sphere(point, self._center, self._radius)
        if self._axis is not None:
            dragged_point = arcball_constrain_to_axis(dragged_point, self._axis)
        self._last_rotation = self._current_rotation
        normal = np.cross(self._grabbed_point, dragged_point)
        if normal @ normal < EPS:
            self._current_rotation = self._start_rotation
        else:  # the quaternion for twice the angle between the two points
            self._current_rotation = quaternion_multiply(
                np.append(normal, self._grabbed_point @ dragged_point), self._start_rotation
            )

    def next(self, acceleration: float = 0.0) -> None:
        """Continue the rotation of the last step by the same angle, plus ``acceleration`` times that angle."""
        extrapolated = quaternion_slerp(self._last_rotation, self._current_rotation, 2.0 + acceleration, 0)
        self._last_rotation, self._current_rotation = self._current_rotation, extrapolated

    def matrix(self) -> Array:
        """Return the rotation as a matrix (4, 4)."""
        return quaternion_matrix(self._current_rotation)


def arcball_map_to_sphere(point: ArrayLike, center: ArrayLike, radius: float) -> Array:
    """Return the point (3,) on the unit sphere that appears at a screen position (2,).

    For positions outside the sphere, return the nearest point on its edge.

    Args:
        point: the position on the screen (2,), where y points down.
        center: center of the sphere on the screen (2,).
        radius: radius of the sphere on the screen.
    """
    (px, py), (cx, cy) = float_array(point, 2).tolist(), float_array(center, 2).tolist()
    x, y = (px - cx) / radius, (cy - py) / radius
    square = x * x + y * y
    if square > 1.0:
        length = sqrt(square)
        return np.array((x / length, y / length, 0.0))
    return np.array((x, y, sqrt(1.0 - square)))


def arcball_constrain_to_axis(point: ArrayLike, axis: ArrayLike) -> Array:
    """Return the point (3,) nearest to ``point`` (3,) on the front half of the unit sphere, in the plane perpendicular
    to ``axis`` (3,).
    """
    p, a = float_array(point, 3), float_array(axis, 3)
    projected = p - a * (a @ p)
    length = vector_norm(projected)
    if length > EPS:
        return np.asarray(projected / (-length if projected[2] < 0.0 else length))
    if a[2] == 1.0:
        return np.array((1.0, 0.0, 0.0))
    return unit_vector((-a[1], a[0], 0.0))


def arcball_nearest_axis(point: ArrayLike, axes: list[Array]) -> Array:
    """Return the axis (3,) whose perpendicular plane is nearest to a point (3,); the first one if several are equally
    near.
    """
    p = float_array(point, 3)
    return max(axes, key=lambda axis: float(arcball_constrain_to_axis(p, axis) @ p))


def _to_quaternion(initial: ArrayLike | None) -> Array:
    if initial is None:
        return np.array((0.0, 0.0, 0.0, 1.0))
    rotation = np.asarray(initial, np.float64)
    if rotation.shape == (4, 4):
        return quaternion_from_matrix(rotation)
    if rotation.shape == (4,):
        return unit_vector(rotation)
    raise ValueError("initial not quaternion or matrix")
