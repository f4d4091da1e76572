"""Rates from counts."""

from __future__ import annotations

from pyros1.bridge.rates import PERIOD, Count, Rate, Rates


def test_a_rate_is_the_mean_of_the_last_seconds() -> None:
    rates = Rates()
    assert rates.is_due(0.0) and rates.rate("/a") is None
    for second in range(6):
        rates.add({"/a": Count(10 * second, 1000 * second)}, 10.0 + second)
        assert rates.is_due(10.0 + second + PERIOD) and not rates.is_due(10.0 + second + 0.9 * PERIOD)
        assert rates.rate("/a") == (Rate(10.0, 1000.0) if second else None)
    for second in range(6, 9):
        rates.add({"/a": Count(50, 5000)}, 10.0 + second)
    assert rates.rate("/a") == Rate(0.0, 0.0)


def test_topics_come_go_and_begin_again() -> None:
    rates = Rates()
    rates.add({"/old": Count(5, 5), "/again": Count(100, 100)}, 0.0)
    rates.add({"/new": Count(2, 4), "/again": Count(4, 6)}, 2.0)
    assert rates.rate("/new") == Rate(1.0, 2.0) and rates.rate("/again") == Rate(2.0, 3.0)
    assert rates.rate("/old") == Rate(0.0, 0.0) and rates.rate("/nowhere") == Rate(0.0, 0.0)
