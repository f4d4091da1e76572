"""Filters over several scans: the median or mean of each ray's last values (no I/O)."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pyros1.robot_nodes.laser_filters.scans import (
    FilterError,
    Floats,
    MatrixTo,
    intensities_of,
    ranges_of,
    replace_fields,
)
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number

_MAX_OBSERVATIONS = 1000
_KINDS = {"MultiChannelMedianFilterFloat": "median", "MultiChannelMeanFilterFloat": "mean"}
_CHAINS = ("range_filter_chain", "intensity_filter_chain")


class HistoryFilter:
    """Combines the last values of each of several channels.

    Args:
        kind: "median" or "mean".
        observations: how many values to combine.
    """

    def __init__(self, kind: str, observations: int) -> None:
        self._kind = kind
        self._history: deque[Floats] = deque(maxlen=observations)

    def add(self, values: Floats) -> Floats:
        """Add a value for each channel, and return the medians or means. Of two middle values, the lower is the median.

        If the number of channels changes, the old values are discarded.
        """
        if self._history and len(self._history[-1]) != len(values):
            self._history.clear()
        self._history.append(values)
        stack = np.stack(self._history)
        if self._kind == "mean":
            mean: Floats = stack.mean(axis=0, dtype=np.float64).astype(np.float32)
            return mean
        middle: Floats = np.sort(stack, axis=0)[(len(stack) - 1) // 2]
        return middle


class ArrayFilter:
    """Passes ranges and intensities through separate filters.

    Args:
        range_filters, intensity_filters: the filters.
    """

    def __init__(self, range_filters: Sequence[HistoryFilter], intensity_filters: Sequence[HistoryFilter]) -> None:
        self._range_filters = range_filters
        self._intensity_filters = intensity_filters

    @classmethod
    def read(cls, parameters: PrivateParameters) -> ArrayFilter:
        """Return the LaserArrayFilter that a chain's parameters describe.

        Raises:
            FilterError: a filter is unknown, or has wrong parameters.
        """
        ranges, intensities = (_read_filters(parameters.value(name), name) for name in _CHAINS)
        if not ranges and not intensities:
            raise FilterError(f"one of {' and '.join(_CHAINS)} must be set, to a list of filters")
        return cls(ranges, intensities)

    @classmethod
    def read_median(cls, parameters: PrivateParameters) -> ArrayFilter:
        """Return the LaserMedianFilter that a chain's parameters describe.

        Raises:
            FilterError: the filter is unknown, or has wrong parameters.
        """
        internal = [parameters.value("internal_filter")]
        return cls(_read_filters(internal, "internal_filter"), _read_filters(internal, "internal_filter"))

    def apply(self, scan: Any, matrix_to: MatrixTo) -> Any:
        """Return the filtered scan."""
        fields = {"ranges": ranges_of(scan)}
        for each in self._range_filters:
            fields["ranges"] = each.add(fields["ranges"])
        intensities = intensities_of(scan)
        if intensities is not None:
            for each in self._intensity_filters:
                intensities = each.add(intensities)
            fields["intensities"] = intensities
        return replace_fields(scan, fields)


def _read_filters(specifications: object, name: str) -> list[HistoryFilter]:
    if specifications is None:
        return []
    if not isinstance(specifications, list):
        raise FilterError(f"{name} must be a list of filters")
    filters = []
    for specification in specifications:
        if not isinstance(specification, Mapping):
            raise FilterError(f"{name} must have a type and params")
        kind = _KINDS.get(str(specification.get("type")).rpartition("/")[2])
        if kind is None:
            raise FilterError(f"{name} may have these types: {', '.join(f'filters/{each}' for each in _KINDS)}")
        values = specification.get("params")
        count = values.get("number_of_observations") if isinstance(values, Mapping) else None
        if not is_number(count) or not 1 <= count <= _MAX_OBSERVATIONS:
            raise FilterError(f"number_of_observations in {name} must be a number from 1 to {_MAX_OBSERVATIONS}")
        filters.append(HistoryFilter(kind, int(count)))
    return filters
