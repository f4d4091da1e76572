"""Code shared by the filters: access to scans as numpy arrays (no I/O)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import Error

Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]
Matrix = NDArray[np.float64]

MatrixTo = Callable[[str], Matrix]
"""Returns the matrix (4, 4) that transforms points from the scan's frame to the given one at the time of the scan.

Raises:
    TransformException: there is no such transform.
"""


class FilterError(Error):
    """A filter cannot be created, or a scan cannot be filtered."""


class ScanFilter(Protocol):
    """A filter of a chain."""

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered sensor_msgs/LaserScan; the given one is not changed.

        Raises:
            FilterError: the scan cannot be filtered.
            TransformException: there is no transform to the frame that the filter needs.
        """


def ranges_of(scan: Any) -> Floats:
    """Return a copy of a scan's ranges."""
    return np.array(scan.ranges, np.float32)


def intensities_of(scan: Any) -> Floats | None:
    """Return a copy of a scan's intensities; None unless there is one for each ray."""
    return np.array(scan.intensities, np.float32) if len(scan.intensities) == len(scan.ranges) else None


def angles_of(scan: Any) -> NDArray[np.float64]:
    """Return the directions of a scan's rays in radians."""
    return float(scan.angle_min) + np.arange(len(scan.ranges), dtype=np.float64) * float(scan.angle_increment)


def replace_fields(scan: Any, fields: Mapping[str, Any]) -> Any:
    """Return a copy of a scan in which some fields are different."""
    names = scan.__slots__
    return type(scan)(**{name: fields.get(name, getattr(scan, name)) for name in names})


def replace_rays(scan: Any, rays: Mask, value: float, intensity: float | None = None) -> Any:
    """Return a copy of a scan in which some rays have another range, and another intensity if one is given."""
    fields: dict[str, Any] = {"ranges": ranges_of(scan)}
    fields["ranges"][rays] = value
    intensities = intensities_of(scan)
    if intensity is not None and intensities is not None:
        intensities[rays] = intensity
        fields["intensities"] = intensities
    return replace_fields(scan, fields)


def points_of(scan: Any) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the indices of the rays within the scanner's limits, and their end points, of shape (n, 3)."""
    ranges = ranges_of(scan).astype(np.float64)
    rays = np.flatnonzero((ranges >= scan.range_min) & (ranges < scan.range_max))
    angles, distances = angles_of(scan)[rays], ranges[rays]
    return rays, np.stack([distances * np.cos(angles), distances * np.sin(angles), np.zeros(len(rays))], axis=1)
