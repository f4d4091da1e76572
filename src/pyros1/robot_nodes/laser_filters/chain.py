"""Creates the filters of a chain from parameters, and passes scans through them (no I/O)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pyros1.ground.suggest import did_you_mean
from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.laser_filters.neighbour_filters import (
    BlobFilter,
    InterpolationFilter,
    ShadowsFilter,
    SpeckleFilter,
)
from pyros1.robot_nodes.laser_filters.scans import FilterError, MatrixTo, ScanFilter
from pyros1.robot_nodes.laser_filters.shape_filters import BoxFilter, FootprintFilter, PolygonFilter
from pyros1.robot_nodes.laser_filters.time_filters import ArrayFilter
from pyros1.robot_nodes.laser_filters.value_filters import (
    AngularBoundsFilter,
    AngularBoundsFilterInPlace,
    IntensityFilter,
    MaskFilter,
    RangeFilter,
    SectorFilter,
)
from pyros1.robot_nodes.shared.parameters import PrivateParameters

PACKAGE = "laser_filters"
FILTERS: Mapping[str, Callable[[PrivateParameters], ScanFilter]] = {
    "InterpolationFilter": InterpolationFilter.read,
    "LaserArrayFilter": ArrayFilter.read,
    "LaserMedianFilter": ArrayFilter.read_median,
    "LaserScanAngularBoundsFilter": AngularBoundsFilter.read,
    "LaserScanAngularBoundsFilterInPlace": AngularBoundsFilterInPlace.read,
    "LaserScanBoxFilter": BoxFilter.read,
    "LaserScanFootprintFilter": FootprintFilter.read,
    "LaserScanIntensityFilter": IntensityFilter.read,
    "LaserScanMaskFilter": MaskFilter.read,
    "LaserScanPolygonFilter": PolygonFilter.read,
    "LaserScanRangeFilter": RangeFilter.read,
    "LaserScanSectorFilter": SectorFilter.read,
    "LaserScanSpeckleFilter": SpeckleFilter.read,
    "ScanBlobFilter": BlobFilter.read,
    "ScanShadowsFilter": ShadowsFilter.read,
    "StaticLaserScanPolygonFilter": PolygonFilter.read,
}
"""The filters by type, without the package's name."""


def make_chain(specifications: object, place: str, report: Callable[[str], object]) -> list[ScanFilter]:
    """Return the filters of a chain.

    Args:
        specifications: a list of filters, each with name, type and params; None for no filters.
        place: the parameter's name, for messages.
        report: called with a one-line message about each invalid parameter that has a default.

    Raises:
        FilterError: a filter is unknown, or lacks a parameter. Without this filter, the robot might see itself.
    """
    if specifications is None:
        return []
    if not isinstance(specifications, list):
        raise FilterError(f"{place} must be a list of filters, each with name, type and params")
    return [make_filter(each, f"{place}[{index}]", report) for index, each in enumerate(specifications)]


def make_filter(specification: object, place: str, report: Callable[[str], object]) -> ScanFilter:
    """Return a filter of a chain.

    Args:
        specification: the filter's name, type and params.
        place, report: see `make_chain`.

    Raises:
        FilterError: see `make_chain`.
    """
    if not isinstance(specification, Mapping) or not isinstance(specification.get("type"), str):
        raise FilterError(f"{place} must have a type, such as {PACKAGE}/LaserScanRangeFilter")
    place = f"{place} ({one_line(str(specification.get('name')), 50)})"
    package, _, kind = specification["type"].rpartition("/")
    if package not in ("", PACKAGE) or kind not in FILTERS:
        text = one_line(specification["type"], 100)
        hint = did_you_mean(kind, FILTERS) or f"; {PACKAGE} has {', '.join(FILTERS)}"
        raise FilterError(f"{place}: there is no filter {text}{hint}")
    values = specification.get("params")
    if values is None:
        values = {}
    if not isinstance(values, Mapping):
        raise FilterError(f"{place}: params must be a mapping, not {one_line(repr(values), 100)}")
    try:
        return FILTERS[kind](PrivateParameters(values, report, place))
    except FilterError as error:
        raise FilterError(f"{place}: {error}") from None


def apply_chain(filters: Sequence[ScanFilter], scan: Any, matrix_to: MatrixTo) -> Any:
    """Return a sensor_msgs/LaserScan that has passed through all filters.

    Raises:
        FilterError: a filter cannot process the scan.
        TransformException: a transform that a filter needs is not available.
    """
    with np.errstate(all="ignore"):  # scans may contain any numbers, and numpy's warnings help nobody
        for each in filters:
            scan = each.apply(scan, matrix_to)
    return scan
