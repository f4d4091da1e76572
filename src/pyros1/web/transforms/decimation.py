"""Reduces the number of points of a curve while preserving its appearance, including spikes (pure)."""

from __future__ import annotations

from collections.abc import Sequence

POINTS_PER_BUCKET = 4
"""Maximum number of points that are kept in each part of a curve: the first, lowest, highest and last one."""


def decimate(times: Sequence[float], values: Sequence[float], max_points: int) -> tuple[list[float], list[float]]:
    """Return some of the points of a curve, in their order.

    The points are divided into parts of equal size; of each, the first, lowest, highest and last are kept. NaN is
    neither the lowest nor the highest, but may be the first or the last.

    Args:
        times: the times of the points.
        values: the values of the points, as many as times.
        max_points: maximum number of points to return, at least 4.
    """
    count = len(times)
    if count <= max_points:
        return list(times), list(values)
    num_buckets = max(1, max_points // POINTS_PER_BUCKET)
    kept: list[int] = []
    for bucket in range(num_buckets):
        begin, end = bucket * count // num_buckets, (bucket + 1) * count // num_buckets
        not_nan = [index for index in range(begin, end) if values[index] == values[index]]
        selected = {begin, end - 1}
        if not_nan:
            selected.add(min(not_nan, key=values.__getitem__))
            selected.add(max(not_nan, key=values.__getitem__))
        kept += sorted(selected)
    return [times[index] for index in kept], [values[index] for index in kept]
