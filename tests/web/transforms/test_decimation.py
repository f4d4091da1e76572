"""Fewer points that look the same."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.transforms.decimation import POINTS_PER_BUCKET, decimate

NUMBERS = st.lists(st.floats(), min_size=1, max_size=400)


@given(NUMBERS, st.integers(4, 200))
def test_order_size_and_spikes(values: list[float], most: int) -> None:
    times = [float(number) for number in range(len(values))]
    kept_times, kept = decimate(times, values, most)
    assert len(kept) == len(kept_times) <= max(most, POINTS_PER_BUCKET)
    assert kept_times == sorted(kept_times)
    assert all(value is values[int(time)] for time, value in zip(kept_times, kept, strict=True))
    assert (kept_times[0], kept_times[-1]) == (times[0], times[-1])
    finite = [value for value in values if not math.isnan(value)]
    if finite:
        assert max(finite) in kept
        assert min(finite) in kept


def test_few_points_stay_as_they_are() -> None:
    assert decimate([1.0, 2.0], [3.0, math.nan], 4)[0] == [1.0, 2.0]


def test_one_spike_of_a_million_stays() -> None:
    values = [0.0] * 1_000_000
    values[123_456] = 1.0
    times, kept = decimate(range(1_000_000), values, 400)
    assert kept[times.index(123_456)] == 1.0
