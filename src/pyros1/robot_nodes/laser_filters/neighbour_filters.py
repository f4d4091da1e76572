"""Filters that compare rays with their neighbours (no I/O)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyros1.robot_nodes.laser_filters.scans import (
    FilterError,
    Floats,
    Mask,
    MatrixTo,
    ranges_of,
    replace_fields,
    replace_rays,
)
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number

_MAX_NEIGHBOURS = 1000


@dataclass(frozen=True)
class ShadowsFilter:
    """Removes points between a near edge and the background, which scanners report when their beam hits both.

    A point is at such an edge if the line to a neighbour is nearly in the direction of the beam.

    Attributes:
        min_angle, max_angle: limits for the angle between that line and the beam, in radians; an angle outside them
            indicates an edge.
        window: how many rays on each side are neighbours.
        neighbours: how many rays on each side of the edge are removed if they are farther than it.
        remove_start: whether the edge itself is also removed.
    """

    min_angle: float = math.radians(10.0)
    max_angle: float = math.radians(170.0)
    window: int = 1
    neighbours: int = 20
    remove_start: bool = False

    @classmethod
    def read(cls, parameters: PrivateParameters) -> ShadowsFilter:
        """Return the filter that a chain's parameters describe."""
        return cls(
            math.radians(parameters.number("min_angle", 10.0)),
            math.radians(parameters.number("max_angle", 170.0)),
            parameters.integer("window", 1, 0, _MAX_NEIGHBOURS),
            parameters.integer("neighbors", 20, 0, _MAX_NEIGHBOURS),
            parameters.flag("remove_shadow_start_point", False),
        )

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan."""
        ranges = ranges_of(scan)
        edges = self._find_edges(ranges, scan.angle_increment)
        removed = edges if self.remove_start else np.zeros(len(ranges), bool)
        removed = removed.copy()
        edge_ranges = np.where(edges, ranges, np.float32(np.inf))
        for offset in _offsets(self.neighbours, len(ranges)):
            here, there = _shifted(len(ranges), offset)
            removed[here] |= edge_ranges[there] < ranges[here]
        return replace_rays(scan, removed, math.nan)

    def _find_edges(self, ranges: Floats, increment: float) -> Mask:
        edges = np.zeros(len(ranges), bool)
        with np.errstate(invalid="ignore"):
            for offset in _offsets(self.window, len(ranges)):
                here, there = _shifted(len(ranges), offset)
                across = np.abs(ranges[there] * np.sin(offset * increment))
                along = ranges[here] - ranges[there] * np.cos(offset * increment)
                angle = np.arctan2(across, along)
                angle[np.isinf(ranges[there])] = np.nan  # nothing was hit there
                edges[here] |= (angle < self.min_angle) | (angle > self.max_angle)
        return edges


@dataclass(frozen=True)
class SpeckleFilter:
    """Removes points with too few other points nearby, such as rain and dust; their ranges become NaN.

    Attributes:
        max_range: in metres; farther points are kept.
        max_difference: maximum distance to the other points, in metres.
        window: minimum number of points nearby.
        by_radius: compare the distance between points, instead of the difference in range of ``window`` consecutive
            rays.
    """

    max_range: float = 2.0
    max_difference: float = 0.4
    window: int = 4
    by_radius: bool = False

    @classmethod
    def read(cls, parameters: PrivateParameters) -> SpeckleFilter:
        """Return the filter that a chain's parameters describe."""
        return cls(
            parameters.number("max_range", 2.0),
            parameters.number("max_range_difference", 0.4),
            parameters.integer("filter_window", 4, 1, _MAX_NEIGHBOURS),
            parameters.integer("filter_type", 0, 0, 1) == 1,
        )

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan.

        Raises:
            FilterError: the scan has fewer rays than the window.
        """
        ranges = ranges_of(scan)
        count = len(ranges) - self.window + 1
        if count <= 2:
            raise FilterError(f"a scan with {len(ranges)} rays is too small for the filter_window {self.window}")
        with np.errstate(invalid="ignore"):
            good = self._by_radius(ranges, scan.angle_increment) if self.by_radius else self._by_range(ranges)
        kept = ranges > self.max_range
        for offset in range(self.window):
            kept[offset : offset + count] |= good[:count]
        return replace_rays(scan, ~kept, math.nan)

    def _by_range(self, ranges: Floats) -> Mask:
        """Return a mask of window starts: True where all ranges in the window are close to its first one."""
        windows = np.lib.stride_tricks.sliding_window_view(ranges, self.window)
        far = np.abs(windows - windows[:, :1]) > self.max_difference
        good: Mask = ~(far | np.isnan(windows)).any(axis=1)
        return good

    def _by_radius(self, ranges: Floats, increment: float) -> Mask:
        """Return a mask of the points: True for those with enough other points nearby."""
        near = np.zeros(len(ranges), np.int64)
        for offset in _offsets(self.window, len(ranges)):
            here, there = _shifted(len(ranges), offset)
            one, other = ranges[here].astype(np.float64), ranges[there].astype(np.float64)
            squared = one * one + other * other - 2 * one * other * np.cos(offset * increment)
            near[here] += np.sqrt(np.maximum(squared, 0.0)) <= self.max_difference
        return near >= self.window


class InterpolationFilter:
    """Replaces ranges outside the scanner's limits with the average of the nearest valid ones on both sides."""

    @classmethod
    def read(cls, parameters: PrivateParameters) -> InterpolationFilter:
        """Return the filter, which has no parameters."""
        return cls()

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan. Before the first ray and after the last one, 1 cm less than the maximum is used."""
        ranges = ranges_of(scan).astype(np.float64)
        valid = ~((ranges <= scan.range_min) | (ranges >= scan.range_max))
        edge = scan.range_max - 0.01
        padded = np.concatenate([[edge], ranges, [edge]])
        numbers = np.arange(len(padded))
        is_valid = np.concatenate([[True], valid, [True]])
        before = np.maximum.accumulate(np.where(is_valid, numbers, 0))
        after = np.minimum.accumulate(np.where(is_valid, numbers, len(padded) - 1)[::-1])[::-1]
        filled = ((padded[before] + padded[after]) / 2)[1:-1]
        return replace_fields(scan, {"ranges": np.where(valid, ranges, filled).astype(np.float32)})


@dataclass(frozen=True)
class BlobFilter:
    """Finds small objects, such as feet: all ranges become negative, except for one in the middle of each object.

    Attributes:
        max_radius: the maximum deviation of an object's ranges from their mean, in metres.
        min_points: the number of rays that an object must exceed.
    """

    max_radius: float
    min_points: int

    @classmethod
    def read(cls, parameters: PrivateParameters) -> BlobFilter:
        """Return the filter that a chain's parameters describe.

        Raises:
            FilterError: a parameter is not set.
        """
        if not all(is_number(parameters.value(name)) for name in ("max_radius", "min_points")):
            raise FilterError("max_radius and min_points must be set, to numbers")
        return cls(parameters.number("max_radius", 0.1), parameters.integer("min_points", 5, 0))

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan."""
        ranges = ranges_of(scan)
        measured = np.concatenate([[False], ranges >= 0, [False]])
        limits = np.flatnonzero(measured[1:] != measured[:-1]).reshape(-1, 2)
        result = -np.abs(ranges)
        scale = max(1.0, abs(scan.angle_increment))
        for begin, end in limits[limits[:, 1] - limits[:, 0] > self.min_points]:
            part = ranges[begin:end].astype(np.float64)
            with np.errstate(invalid="ignore"):
                radius = np.abs(part - part.mean()).max() * scale
            if radius < self.max_radius:
                middle = begin + (end - begin) // 2
                result[middle] = ranges[middle]
        return replace_fields(scan, {"ranges": result})


def _offsets(reach: int, count: int) -> list[int]:
    """Return the offsets to the neighbours of a ray (without 0) that are possible in a scan of ``count`` rays."""
    reach = min(reach, max(count - 1, 0))
    return [offset for offset in range(-reach, reach + 1) if offset]


def _shifted(count: int, offset: int) -> tuple[slice, slice]:
    """Return the rays that have a neighbour at an offset, and these neighbours."""
    return slice(max(0, -offset), count - max(0, offset)), slice(max(0, offset), count - max(0, -offset))
