"""Filters that remove rays that end inside a shape, such as the robot itself (no I/O)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.robot_nodes.laser_filters.scans import FilterError, Mask, MatrixTo, points_of, replace_rays
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number
from pyros1.robot_nodes.shared.transforms import transform_points

_Points = NDArray[np.float64]

MAX_CORNERS = 1000
"""Maximum number of corners of a polygon; each takes time for each scan."""


class ShapeFilter:
    """Removes the rays that end inside a shape; their ranges become NaN.

    Args:
        frame: the frame of the shape.
        invert: whether to remove the rays that end outside instead.
    """

    def __init__(self, frame: str, invert: bool = False) -> None:
        self.frame = frame
        self.invert = invert

    def contains(self, points: _Points) -> Mask:
        """Return a mask of the points: True for those inside the shape.

        Args:
            points: of shape (n, 3), in the shape's frame.
        """
        raise NotImplementedError

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan; rays outside the scanner's limits do not change.

        Raises:
            TransformException: there is no transform from the scan's frame to the shape's frame.
        """
        rays, points = points_of(scan)
        if self.frame != scan.header.frame_id:
            points = transform_points(matrix_to(self.frame), points)
        removed = np.zeros(len(scan.ranges), bool)
        removed[rays] = self.contains(points) != self.invert
        return replace_rays(scan, removed, math.nan)


class BoxFilter(ShapeFilter):
    """Removes the rays that end inside a box.

    Args:
        frame, invert: see `ShapeFilter`.
        minimum, maximum: two opposite corners: x, y and z in metres.
    """

    def __init__(
        self,
        frame: str,
        minimum: tuple[float, float, float],
        maximum: tuple[float, float, float],
        invert: bool = False,
    ) -> None:
        super().__init__(frame, invert)
        self._minimum = np.array(minimum)
        self._maximum = np.array(maximum)

    @classmethod
    def read(cls, parameters: PrivateParameters) -> BoxFilter:
        """Return the filter that a chain's parameters describe."""
        minimum_x, minimum_y, minimum_z = (parameters.number(f"min_{axis}", -1.0) for axis in "xyz")
        maximum_x, maximum_y, maximum_z = (parameters.number(f"max_{axis}", 1.0) for axis in "xyz")
        return cls(
            _frame(parameters, "box_frame", "base_link"),
            (minimum_x, minimum_y, minimum_z),
            (maximum_x, maximum_y, maximum_z),
            parameters.flag("invert", False),
        )

    def contains(self, points: _Points) -> Mask:
        """Return a mask of the points inside the shape; see `ShapeFilter.contains`."""
        inside: Mask = np.logical_and.reduce((points > self._minimum) & (points < self._maximum), axis=1)
        return inside


class FootprintFilter(ShapeFilter):
    """Removes the rays that end above or below a square around base_link.

    Args:
        radius: half the length of its side in metres.
    """

    def __init__(self, radius: float) -> None:
        super().__init__("base_link")
        self._radius = radius

    @classmethod
    def read(cls, parameters: PrivateParameters) -> FootprintFilter:
        """Return the filter that a chain's parameters describe.

        Raises:
            FilterError: inscribed_radius is not set.
        """
        radius = parameters.value("inscribed_radius")
        if not is_number(radius):
            raise FilterError("inscribed_radius must be set, to a number of metres")
        return cls(radius)

    def contains(self, points: _Points) -> Mask:
        """Return a mask of the points inside the shape; see `ShapeFilter.contains`."""
        inside: Mask = np.abs(points[:, :2]).max(axis=1) <= self._radius
        return inside


class PolygonFilter(ShapeFilter):
    """Removes the rays that end above or below a polygon.

    Args:
        frame, invert: see `ShapeFilter`.
        corners: the polygon's corners, of shape (n, 2), in metres.
        padding: how far each corner is moved away from both axes, in metres.
    """

    def __init__(self, frame: str, corners: _Points, padding: float = 0.0, invert: bool = False) -> None:
        super().__init__(frame, invert)
        self._corners = corners + np.sign(corners) * padding

    @classmethod
    def read(cls, parameters: PrivateParameters) -> PolygonFilter:
        """Return the filter that a chain's parameters describe.

        Raises:
            FilterError: the polygon, or its frame, is not set, or it has too many corners.
        """
        polygon = parameters.value("polygon")
        if not isinstance(polygon, list) or len(polygon) < 3 or not all(map(_is_corner, polygon)):
            raise FilterError("polygon must be set, to a list of corners: [[x, y], [x, y], [x, y]]")
        if len(polygon) > MAX_CORNERS:
            raise FilterError(f"the polygon has {len(polygon)} corners, and {MAX_CORNERS} are the most")
        if not parameters.text("polygon_frame", ""):
            raise FilterError("polygon_frame must be set")
        return cls(
            _frame(parameters, "polygon_frame", ""),
            np.array(polygon, np.float64),
            parameters.number("polygon_padding", 0.0),
            parameters.flag("invert", False),
        )

    def contains(self, points: _Points) -> Mask:
        """Return a mask of the points inside the shape; see `ShapeFilter.contains`."""
        x, y = points[:, 0], points[:, 1]
        inside = np.zeros(len(points), bool)
        # A point is inside if a line from it towards positive x crosses the edges an odd number of times.
        for (x1, y1), (x2, y2) in zip(self._corners, np.roll(self._corners, -1, axis=0), strict=True):
            if y1 != y2:
                inside ^= ((y1 > y) != (y2 > y)) & (x < x1 + (y - y1) * (x2 - x1) / (y2 - y1))
        return inside


def _is_corner(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(is_number, value))


def _frame(parameters: PrivateParameters, name: str, default: str) -> str:
    return parameters.text(name, default).lstrip("/")
