"""Projects points to a laser scan, and converts a laser scan to points (no I/O)."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pyros1.robot_nodes.shared.parameters import PrivateParameters

MAX_RAYS = 1_000_000
"""Maximum number of rays of a scan."""
_LARGEST = sys.float_info.max
_LARGEST_ANGLE = 1000.0
_SMALLEST_INCREMENT = 1e-6


@dataclass(frozen=True)
class ScanSettings:
    """The geometry of the scan, and which points are used.

    Attributes:
        min_height, max_height: minimum and maximum z of used points, in metres.
        angle_min, angle_max: the directions of the first ray and of the end of the scan, in radians.
        angle_increment: the angle between rays in radians.
        scan_time: the time between scans in seconds, which is only copied into the scan.
        range_min, range_max: minimum and maximum distance of used points, in metres.
        use_inf: whether the range of rays without a point is infinity, not ``range_max + inf_epsilon``.
        inf_epsilon: distance in metres; see ``use_inf``.
    """

    min_height: float = sys.float_info.min
    max_height: float = _LARGEST
    angle_min: float = -math.pi
    angle_max: float = math.pi
    angle_increment: float = math.pi / 180
    scan_time: float = 1.0 / 30.0
    range_min: float = 0.0
    range_max: float = _LARGEST
    use_inf: bool = True
    inf_epsilon: float = 1.0

    @property
    def num_rays(self) -> int:
        """The number of rays of the scan."""
        # In single precision, as in the message: -pi to pi in steps of one degree gives 360 rays, not 361.
        single = np.float32
        angle = float((single(self.angle_max) - single(self.angle_min)) / single(self.angle_increment))
        return max(1, math.ceil(angle))


def read_settings(parameters: PrivateParameters) -> ScanSettings:
    """Read the settings from a node's parameters; impossible angles are reported and replaced with the defaults."""
    default = ScanSettings()
    number = parameters.number
    angle_min = number("angle_min", default.angle_min, -_LARGEST_ANGLE, _LARGEST_ANGLE)
    angle_max = number("angle_max", default.angle_max, -_LARGEST_ANGLE, _LARGEST_ANGLE)
    if angle_max <= angle_min:
        parameters.report_invalid("angle_max", angle_max, f"more than angle_min, {angle_min:g}", default.angle_max)
        angle_min, angle_max = default.angle_min, default.angle_max
    smallest = max((angle_max - angle_min) / MAX_RAYS, _SMALLEST_INCREMENT)
    return ScanSettings(
        min_height=number("min_height", default.min_height),
        max_height=number("max_height", default.max_height),
        angle_min=angle_min,
        angle_max=angle_max,
        angle_increment=number("angle_increment", default.angle_increment, smallest),
        scan_time=number("scan_time", default.scan_time),
        range_min=number("range_min", default.range_min),
        range_max=number("range_max", default.range_max),
        use_inf=parameters.flag("use_inf", default.use_inf),
        inf_epsilon=number("inf_epsilon", default.inf_epsilon),
    )


def project(positions: NDArray[np.float64], settings: ScanSettings) -> NDArray[np.float32]:
    """Return the ranges of a scan: for each ray, the distance to the nearest point in the sector that begins there.

    Args:
        positions: the points, of shape (n, 3), in metres; x is forwards, z upwards. NaN is ignored.
        settings: the geometry of the scan.
    """
    empty = math.inf if settings.use_inf else settings.range_max + settings.inf_epsilon
    with np.errstate(all="ignore"):  # numbers may be too large for float32, or not finite
        return _nearest(positions, settings, empty)


def _nearest(positions: NDArray[np.float64], settings: ScanSettings, empty: float) -> NDArray[np.float32]:
    ranges = np.full(settings.num_rays, empty, np.float32)
    height = positions[:, 2]
    points = positions[(height >= settings.min_height) & (height <= settings.max_height)]
    x, y = points[:, 0], points[:, 1]
    distances, angles = np.hypot(x, y), np.arctan2(y, x)
    counts = (distances >= settings.range_min) & (distances <= settings.range_max)
    counts &= (angles >= settings.angle_min) & (angles <= settings.angle_max)
    start, step = float(np.float32(settings.angle_min)), float(np.float32(settings.angle_increment))
    rays = ((angles[counts] - start) / step).astype(np.int64)
    np.clip(rays, 0, len(ranges) - 1, out=rays)
    np.minimum.at(ranges, rays, distances[counts].astype(np.float32))
    return ranges


def unproject(scan: Any) -> dict[str, NDArray[Any]]:
    """Return the points of a sensor_msgs/LaserScan, leaving out rays outside the scan's limits.

    Returns:
        Arrays of float32: x, y, z (which is 0), and intensity if the scan has intensities; and index, the index of the
        ray, as int32.
    """
    ranges = np.asarray(scan.ranges, np.float64)
    valid = np.flatnonzero((ranges >= scan.range_min) & (ranges < scan.range_max))
    with np.errstate(all="ignore"):
        distances, angles = ranges[valid], scan.angle_min + valid * scan.angle_increment
        x, y = (distances * np.cos(angles)).astype(np.float32), (distances * np.sin(angles)).astype(np.float32)
    columns: dict[str, NDArray[Any]] = {"x": x, "y": y, "z": np.zeros(len(valid), np.float32)}
    if len(scan.intensities) == len(ranges):
        columns["intensity"] = np.asarray(scan.intensities, np.float32)[valid]
    columns["index"] = valid.astype(np.int32)
    return columns
