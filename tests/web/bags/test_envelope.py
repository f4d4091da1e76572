"""Curves in bounded memory."""

from __future__ import annotations

import math
import random

from pyros1.web.bags.envelope import Envelope


def filled(points: list[tuple[float, float]], parts: int = 10, end: float = 100.0) -> Envelope:
    envelope = Envelope(0.0, end, parts)
    for time, value in points:
        envelope.add(time, value)
    return envelope


def test_few_points_stay_as_they_are() -> None:
    points = [(1.0, 5.0), (20.0, 3.0), (21.0, 4.0), (99.0, 1.0)]
    times, values = filled(points).points()
    assert list(zip(times, values, strict=True)) == points


def test_spikes_stay_and_the_number_is_bounded() -> None:
    chance = random.Random(2)
    points = [(number / 1000, chance.random()) for number in range(100_000)]
    points[12_345] = (12.345, 99.0)
    points[77_777] = (77.777, -99.0)
    times, values = filled(points).points()
    assert len(times) <= 40
    assert times == sorted(times)
    assert (12.345, 99.0) in zip(times, values, strict=True)
    assert (77.777, -99.0) in zip(times, values, strict=True)
    assert values[0] == points[0][1] and values[-1] == points[-1][1]


def test_each_part_keeps_its_least_and_greatest() -> None:
    chance = random.Random(3)
    for _ in range(50):
        points = sorted((chance.uniform(0, 100), chance.uniform(-9, 9)) for _ in range(500))
        kept = list(zip(*filled(points).points(), strict=True))
        for part in range(10):
            inside = [value for time, value in points if int(time / 10) == part]
            left = [value for time, value in kept if int(time / 10) == part]
            assert (min(inside), max(inside)) == (min(left), max(left))
        assert set(kept) <= set(points)


def test_nan_is_neither_least_nor_greatest() -> None:
    times, values = filled([(0.0, math.nan), (1.0, 2.0), (2.0, math.nan), (3.0, -1.0), (4.0, math.nan)]).points()
    assert [value for value in values if not math.isnan(value)] == [2.0, -1.0]
    assert times[0] == 0.0 and times[-1] == 4.0


def test_times_outside_count_as_the_edges() -> None:
    assert filled([(-5.0, 1.0), (500.0, 2.0)]).points() == ([-5.0, 500.0], [1.0, 2.0])
