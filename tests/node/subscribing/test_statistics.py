"""statistics: what came from a publisher in a window of time (P41)."""

from __future__ import annotations

import statistics
from itertools import pairwise
from typing import Any

import pytest

from pyros1.node.subscribing.statistics import Limits, Window, summarise


def test_a_window() -> None:
    window = Window(10.0)
    times = [10.2, 10.25, 10.5, 11.0]
    reports = [window.add(now, 5, seq, now - 0.125) for now, seq in zip(times, (3, 4, 7, 8), strict=True)]
    assert reports[:3] == [None] * 3
    report: Any = reports[3]
    assert report[:5] == (10.0, 11.0, 4, 2, 20)
    periods = [b - a for a, b in pairwise(times)]
    assert abs(report.period.mean - statistics.fmean(periods)) < 1e-12 and report.period.maximum == max(periods)
    assert abs(report.period.deviation - statistics.stdev(periods)) < 1e-12
    assert report.age == (0.125, 0.0, 0.125)
    assert window.add(11.5, 1) is None


def test_the_length_of_windows() -> None:
    window, now, lengths = Window(0.0, Limits(2, 10, 0.5, 4)), 0.0, []
    for step in (*[2.0] * 4, *[0.01] * 2000):
        now += step
        report = window.add(now, 1)
        if report is not None:
            lengths.append(report.stop - report.start)
    assert 4.0 <= max(lengths) < 4.02 and 0.5 <= lengths[-1] < 0.52


@pytest.mark.parametrize(("longest", "lengths"), [(4.0, [1, 2, 4, 4]), (3.0, [1, 2, 2, 2])])
def test_windows_of_few_messages_are_doubled_up_to_their_limit(longest: float, lengths: list[int]) -> None:
    window, found = Window(0.0, Limits(10, 20, 0.5, longest)), []
    for now in range(1, 20):
        report = window.add(float(now), 1)
        if report is not None:
            found.append(report.stop - report.start)
    assert found[:4] == lengths


def test_spread() -> None:
    assert summarise([]) == (0, 0, 0) and summarise([2.0]) == (2, 0, 2)
