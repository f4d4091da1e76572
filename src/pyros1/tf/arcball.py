"""Turning things with the mouse (K. Shoemake's arcball): see `pyros1.tf.transformations`."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, sqrt
from typing import Any

from pyros1.tf.quaternions import (
    EPS,
    Matrix,
    Vector,
    cross,
    dot,
    normalized,
    quaternion_from_matrix,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
)


def arcball_map_to_sphere(point: Vector, center: Vector, radius: float) -> list[float]:
    """Return where on the unit sphere a point of the window lies; outside the ball, the nearest on its edge.

    Args:
        point: x to the right and y down, as windows count.
        center: of the ball in the window.
        radius: of the ball in the window.
    """
    x, y = (point[0] - center[0]) / radius, (center[1] - point[1]) / radius
    square = x * x + y * y
    if square > 1.0:
        return [x / sqrt(square), y / sqrt(square), 0.0]
    return [x, y, sqrt(1.0 - square)]


def arcball_constrain_to_axis(point: Vector, axis: Vector) -> list[float]:
    """Return the point of the sphere nearest to another of those perpendicular to an axis, in front."""
    height = dot(point, axis)
    flat = [a - b * height for a, b in zip(point, axis, strict=True)]
    length = hypot(*flat)
    if length > EPS:
        sign = -1.0 if flat[2] < 0 else 1.0
        return [sign * part / length for part in flat]
    return [1.0, 0.0, 0.0] if axis[2] == 1.0 else normalized([-axis[1], axis[0], 0.0])


def arcball_nearest_axis(point: Vector, axes: Sequence[Vector] | None) -> Vector | None:
    """Return the axis whose circle on the sphere comes nearest to a point; None without axes."""
    return max(axes, key=lambda axis: dot(arcball_constrain_to_axis(point, axis), point)) if axes else None


class Arcball:
    """A ball that is turned by dragging.

    Args:
        initial: how it is turned, a quaternion or a matrix of four rows; None for not at all.

    Raises:
        ValueError: ``initial`` is neither.
    """

    def __init__(self, initial: Any = None) -> None:
        self._center: Vector = [0.0, 0.0]
        self._radius = 1.0
        self._axes: list[list[float]] | None = None
        self._axis: Vector | None = None
        self._constrain = False
        self._down = [0.0, 0.0, 1.0]
        self._start = self._before = self._now = _rotation(initial)

    def place(self, center: Vector, radius: float) -> None:
        """Say where in the window the ball is.

        Args:
            center: x and y.
            radius: in the same unit.
        """
        self._center, self._radius = [float(center[0]), float(center[1])], float(radius)

    def setaxes(self, *axes: Vector | None) -> None:
        """Set the axes about which alone it turns while constrained; None for no axes."""
        given = [axis for axis in axes if axis is not None]
        self._axes = [normalized(axis) for axis in given] or None

    def setconstrain(self, constrain: bool) -> None:
        """Say whether it turns about the axes only."""
        self._constrain = bool(constrain)

    def getconstrain(self) -> bool:
        """Return whether it turns about the axes only."""
        return self._constrain

    def down(self, point: Vector) -> None:
        """Begin to drag at a point of the window."""
        self._down = arcball_map_to_sphere(point, self._center, self._radius)
        self._start = self._before = self._now
        self._axis = arcball_nearest_axis(self._down, self._axes) if self._constrain else None
        if self._axis is not None:
            self._down = arcball_constrain_to_axis(self._down, self._axis)

    def drag(self, point: Vector) -> None:
        """Turn the ball so that what was under the mouse comes to another point of the window."""
        to = arcball_map_to_sphere(point, self._center, self._radius)
        if self._axis is not None:
            to = arcball_constrain_to_axis(to, self._axis)
        self._before = self._now
        axis = cross(self._down, to)
        turned = [*axis, dot(self._down, to)]
        self._now = self._start if dot(axis, axis) < EPS else quaternion_multiply(turned, self._start)

    def next(self, acceleration: float = 0.0) -> None:
        """Go on turning as with the last two positions; ``acceleration`` is added to each step."""
        further = quaternion_slerp(self._before, self._now, 2.0 + acceleration, 0)
        self._before, self._now = self._now, further

    def matrix(self) -> Matrix:
        """Return the rotation as a matrix."""
        return quaternion_matrix(self._now)


def _rotation(initial: Any) -> list[float]:
    if initial is None:
        return [0.0, 0.0, 0.0, 1.0]
    if len(initial) == 4:
        if all(hasattr(part, "__len__") and len(part) == 4 for part in initial):
            return quaternion_from_matrix(initial)
        if not any(hasattr(part, "__len__") for part in initial):
            return normalized(initial)
    raise ValueError("the ball's rotation must be a quaternion or a matrix of four rows")
