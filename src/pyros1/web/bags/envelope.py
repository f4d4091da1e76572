"""A curve of any length in bounded memory, with its spikes preserved. Pure."""

from __future__ import annotations

from math import isnan


class Envelope:
    """The first, lowest, highest and last point of each part of a time span.

    Args:
        begin: where the span begins, in seconds.
        end: where it ends, later than `begin`.
        parts: number of equal parts into which it is divided.
    """

    def __init__(self, begin: float, end: float, parts: int) -> None:
        self._begin = begin
        self._scale = parts / (end - begin)
        self._last = parts - 1
        self._parts: dict[int, list[tuple[float, float]]] = {}

    def add(self, time: float, value: float) -> None:
        """Add a point; times outside the span count as its edges. NaN is neither lowest nor highest."""
        number = min(self._last, max(0, int((time - self._begin) * self._scale)))
        point = (time, value)
        part = self._parts.get(number)
        if part is None:
            self._parts[number] = [point] * 4
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
        for number in sorted(self._parts):
            for time, value in sorted({id(point): point for point in self._parts[number]}.values(), key=_time):
                times.append(time)
                values.append(value)
        return times, values


def _time(point: tuple[float, float]) -> float:
    return point[0]
