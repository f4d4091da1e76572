"""Reduces a curve of any length to bounded memory while preserving its spikes (no I/O)."""

from __future__ import annotations

from math import isnan


class Envelope:
    """Keeps the first, lowest, highest and last point in each part of a time span.

    Args:
        begin: the start of the time span, in seconds.
        end: the end of the time span, later than `begin`.
        parts: number of equal parts into which the time span is divided.
    """

    def __init__(self, begin: float, end: float, parts: int) -> None:
        self._begin = begin
        self._parts_per_second = parts / (end - begin)
        self._last_index = parts - 1
        self._parts: dict[int, list[tuple[float, float]]] = {}

    def add(self, time: float, value: float) -> None:
        """Add a point. A time outside the span belongs to the nearest part. NaN is neither lowest nor highest."""
        index = min(self._last_index, max(0, int((time - self._begin) * self._parts_per_second)))
        point = (time, value)
        part = self._parts.get(index)
        if part is None:
            self._parts[index] = [point] * 4
            return
        if value < part[1][1] or isnan(part[1][1]):
            part[1] = point
        if value > part[2][1] or isnan(part[2][1]):
            part[2] = point
        part[3] = point

    def points(self) -> tuple[list[float], list[float]]:
        """Return the times and the values of the kept points, in order of time."""
        times: list[float] = []
        values: list[float] = []
        for index in sorted(self._parts):
            for time, value in sorted({id(point): point for point in self._parts[index]}.values(), key=_time_of):
                times.append(time)
                values.append(value)
        return times, values


def _time_of(point: tuple[float, float]) -> float:
    return point[0]
