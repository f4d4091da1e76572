"""Filters that consider each ray alone: its range, intensity, direction or index (no I/O)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyros1.ground.timing import Duration
from pyros1.robot_nodes.laser_filters.scans import (
    FilterError,
    MatrixTo,
    angles_of,
    intensities_of,
    ranges_of,
    replace_fields,
    replace_rays,
)
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number

_LARGE = 100000.0


@dataclass(frozen=True)
class RangeFilter:
    """Replaces ranges at or below a lower threshold, and at or above an upper one.

    Attributes:
        use_message_range_limits: whether to use the scanner's limits as thresholds.
        lower_threshold, upper_threshold: the thresholds in metres.
        lower_replacement_value, upper_replacement_value: the ranges that replace them, in metres.
    """

    use_message_range_limits: bool = False
    lower_threshold: float = 0.0
    upper_threshold: float = _LARGE
    lower_replacement_value: float = math.nan
    upper_replacement_value: float = math.nan

    @classmethod
    def read(cls, parameters: PrivateParameters) -> RangeFilter:
        """Return the filter that a chain's parameters describe."""
        return cls(
            parameters.flag("use_message_range_limits", False),
            parameters.number("lower_threshold", 0.0),
            _any_float(parameters, "upper_threshold", _LARGE),
            _any_float(parameters, "lower_replacement_value", math.nan),
            _any_float(parameters, "upper_replacement_value", math.nan),
        )

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan."""
        lower, upper = self.lower_threshold, self.upper_threshold
        if self.use_message_range_limits:
            lower, upper = scan.range_min, scan.range_max
        ranges = ranges_of(scan)
        is_low = ranges <= lower
        is_high = (ranges >= upper) & ~is_low
        ranges[is_low], ranges[is_high] = self.lower_replacement_value, self.upper_replacement_value
        return replace_fields(scan, {"ranges": ranges})


@dataclass(frozen=True)
class IntensityFilter:
    """Removes rays whose intensity is at or below a lower threshold, or at or above an upper one.

    Attributes:
        lower_threshold, upper_threshold: the thresholds.
        invert: whether to remove the other rays instead.
        override_range: whether the ranges of removed rays become NaN.
        override_intensity: whether intensities become 0 for removed rays, and 1 for all others.
    """

    lower_threshold: float = 8000.0
    upper_threshold: float = _LARGE
    invert: bool = False
    override_range: bool = True
    override_intensity: bool = False

    @classmethod
    def read(cls, parameters: PrivateParameters) -> IntensityFilter:
        """Return the filter that a chain's parameters describe."""
        return cls(
            parameters.number("lower_threshold", 8000.0),
            _any_float(parameters, "upper_threshold", _LARGE),
            parameters.flag("invert", False),
            parameters.flag("filter_override_range", True),
            parameters.flag("filter_override_intensity", False),
        )

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan."""
        intensities, ranges = intensities_of(scan), ranges_of(scan)
        if intensities is None:
            return scan
        removed = ((intensities <= self.lower_threshold) | (intensities >= self.upper_threshold)) != self.invert
        if self.override_range:
            ranges[removed] = math.nan
        if self.override_intensity:
            intensities = np.where(removed, np.float32(0), np.float32(1))
        return replace_fields(scan, {"ranges": ranges, "intensities": intensities})


@dataclass(frozen=True)
class AngularBoundsFilter:
    """Keeps the rays between two directions, and removes the others from the scan.

    Attributes:
        lower_angle, upper_angle: in radians.
    """

    lower_angle: float
    upper_angle: float

    @classmethod
    def read(cls, parameters: PrivateParameters) -> AngularBoundsFilter:
        """Return the filter that a chain's parameters describe."""
        return cls(*_read_bounds(parameters))

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan. As in stock ROS, at least the first ray from ``lower_angle`` on is kept.

        Raises:
            FilterError: the time of its first ray cannot be computed.
        """
        angles = angles_of(scan)
        first, last = self.lower_angle, self.upper_angle
        if scan.angle_increment <= 0:  # the scanner turns clockwise
            angles, first, last = -angles, -last, -first
        begin = int(np.count_nonzero(angles < first))
        end = max(int(np.count_nonzero(angles <= last)), begin + 1)
        kept = slice(begin, end)
        count = len(scan.ranges[kept])
        start = float(scan.angle_min + begin * scan.angle_increment)
        try:
            stamp = scan.header.stamp + Duration(begin * float(scan.time_increment))
        except (OverflowError, TypeError, ValueError):  # not finite, or before 1970
            raise FilterError(f"a scan with the time_increment {scan.time_increment:g} cannot be cut") from None
        header = type(scan.header)(seq=scan.header.seq, stamp=stamp, frame_id=scan.header.frame_id)
        fields = {
            "header": header,
            "angle_min": start,
            "angle_max": start + max(count - 1, 0) * scan.angle_increment,
            "ranges": ranges_of(scan)[kept],
        }
        intensities = intensities_of(scan)
        return replace_fields(scan, fields if intensities is None else {**fields, "intensities": intensities[kept]})


@dataclass(frozen=True)
class AngularBoundsFilterInPlace:
    """Sets the ranges of rays between two directions to more than the scanner's maximum range.

    Attributes:
        lower_angle, upper_angle: in radians.
    """

    lower_angle: float
    upper_angle: float

    @classmethod
    def read(cls, parameters: PrivateParameters) -> AngularBoundsFilterInPlace:
        """Return the filter that a chain's parameters describe."""
        return cls(*_read_bounds(parameters))

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan."""
        angles = angles_of(scan)
        inside = (angles > self.lower_angle) & (angles < self.upper_angle)
        return replace_rays(scan, inside, scan.range_max + 1.0, 0.0)


@dataclass(frozen=True)
class SectorFilter:
    """Sets the ranges of rays that end in a sector of a ring to more than the scanner's maximum range.

    Attributes:
        angle_min, angle_max: the directions in which the sector begins and ends, counter-clockwise, in radians.
        range_min, range_max: the radii of the ring in metres.
        clear_inside: False to set the rays that end elsewhere instead.
    """

    angle_min: float = 0.0
    angle_max: float = 0.0
    range_min: float = 0.0
    range_max: float = _LARGE
    clear_inside: bool = True

    @classmethod
    def read(cls, parameters: PrivateParameters) -> SectorFilter:
        """Return the filter that a chain's parameters describe."""
        return cls(
            parameters.number("angle_min", 0.0),
            parameters.number("angle_max", 0.0),
            parameters.number("range_min", 0.0),
            _any_float(parameters, "range_max", _LARGE),
            parameters.flag("clear_inside", True) != parameters.flag("invert", False),
        )

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan."""
        ranges, beyond, width = ranges_of(scan), angles_of(scan) - self.angle_min, self.angle_max - self.angle_min
        if width < 0:  # the sector contains the direction pi
            width += 2 * math.pi
            beyond[beyond < 0] += 2 * math.pi
        inside = (beyond > 0) & (beyond < width) & (ranges > self.range_min) & (ranges < self.range_max)
        return replace_rays(scan, inside == self.clear_inside, scan.range_max + 1.0, 0.0)


@dataclass(frozen=True)
class MaskFilter:
    """Removes rays with the given indices.

    Attributes:
        masks: the indices of the rays, by the scan's frame.
    """

    masks: Mapping[str, tuple[int, ...]]

    @classmethod
    def read(cls, parameters: PrivateParameters) -> MaskFilter:
        """Return the filter that a chain's parameters describe.

        Raises:
            FilterError: there are no masks, or they are not lists of numbers.
        """
        masks = parameters.value("masks")
        if not isinstance(masks, Mapping) or not masks:
            raise FilterError("masks must be set, to lists of rays by the names of frames")
        for frame, rays in masks.items():
            if not isinstance(rays, list) or not all(type(ray) is int and ray >= 0 for ray in rays):
                raise FilterError(f"masks/{frame} must be a list of numbers of rays")
        return cls({frame: tuple(rays) for frame, rays in masks.items()})

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan. A scan whose frame has no mask is not changed."""
        mask = self.masks.get(scan.header.frame_id)
        if mask is None:
            return scan
        removed = np.zeros(len(scan.ranges), bool)
        removed[[ray for ray in mask if ray < len(removed)]] = True
        return replace_rays(scan, removed, math.nan)


def _read_bounds(parameters: PrivateParameters) -> tuple[float, float]:
    """Return the parameters lower_angle and upper_angle.

    Raises:
        FilterError: the parameters are not both numbers.
    """
    lower, upper = parameters.value("lower_angle"), parameters.value("upper_angle")
    if not is_number(lower) or not is_number(upper):
        raise FilterError("lower_angle and upper_angle must be set, to angles in radians")
    return float(lower), float(upper)


def _any_float(parameters: PrivateParameters, name: str, default: float) -> float:
    """Return a number, which may be infinite or NaN."""
    value = parameters.value(name)
    return value if isinstance(value, float) else parameters.number(name, default)
