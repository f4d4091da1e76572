"""Reduces the number of points in a curve while preserving its appearance, including spikes (no I/O)."""

from __future__ import annotations

from collections.abc import Sequence

POINTS_PER_BUCKET = 4
"""Maximum number of points kept per part of a curve: the first, the lowest, the highest and the last."""


def decimate(times: Sequence[float], values: Sequence[float], max_points: int) -> tuple[list[float], list[float]]:
    """Return some of a curve's points, in their order.

    The points are divided into parts of equal size; of each part, the first, lowest, highest and last points are kept.
    NaN counts as neither lowest nor highest, but may be first or last.

    Args:
        times: the points' times.
        values: the points' values, as many as there are times.
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
