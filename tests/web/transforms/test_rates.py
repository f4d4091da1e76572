"""Rates of fast and of slow topics."""

from __future__ import annotations

import pytest

from pyros1.web.transforms.rates import NO_TRAFFIC, SILENCE_TIMEOUT, CountMeter, Meter, Rate

SIZE = 10


def looked(hz: float, seconds: float, period: float = 1.0) -> list[float | None]:
    """Return the rates that looks at a topic of a constant rate give."""
    count_meter = CountMeter(0.0, 0, 0)
    found: list[float | None] = []
    for number in range(1, int(seconds / period) + 1):
        at = number * period
        count = int(at * hz + 1e-9)
        count_meter.update(at, count, count * SIZE)
        rate = count_meter.rate()
        found.append(rate and rate.hz)
        assert rate is None or rate.bytes == pytest.approx(rate.hz * SIZE)
    return found


@pytest.mark.parametrize("hz", [0.1, 0.25, 0.5, 1.0, 2.0, 10.0, 300.0])
def test_a_constant_rate_is_constant(hz: float) -> None:
    """A topic of 0.5 Hz alternated between 0 Hz and 1 Hz."""
    found = looked(hz, 60)
    while found and found[0] in (None, 0.0):  # until two messages have come
        assert found.pop(0) is None or hz < 1 / SILENCE_TIMEOUT + 0.02
    assert found and all(each == pytest.approx(hz, rel=0.01) for each in found), found


def test_of_many_messages_the_newest_make_the_rate() -> None:
    """At most ten thousand are kept; those before were quicker."""
    meter, at = Meter(0.0), 0.0
    for period in (0.00001, 0.0001):
        for _ in range(10_000):
            at += period
            meter.add(at, SIZE)
    rate = meter.rate(at)
    assert rate is not None and rate.hz == pytest.approx(10_000.0)


def test_the_looks_may_lie_in_between() -> None:
    found = [each for each in looked(0.5, 60, 1.1) if each]
    assert all(0.4 < each < 0.65 for each in found), found
    assert len(found) > 40


def test_a_topic_that_ends_has_no_rate_soon_and_one_that_begins_has_one() -> None:
    count_meter = CountMeter(0.0, 0, 0)
    assert count_meter.rate() is None
    for at in range(1, 6):
        count_meter.update(at, at * 50, at * 500)
    assert count_meter.rate() == Rate(50.0, 500.0)
    count_meter.update(6.0, 250, 2500)
    assert count_meter.rate() == NO_TRAFFIC
    for at in range(7, 60):
        count_meter.update(at, 250, 2500)
    count_meter.update(60.0, 251, 2510)
    assert count_meter.rate() is None  # one message is no rate
    count_meter.update(61.0, 271, 2710)
    assert count_meter.rate() == Rate(20.0, 200.0)  # not of the pause


def test_nothing_is_zero_after_a_while() -> None:
    count_meter, meter = CountMeter(0.0, 7, 70), Meter(0.0)
    count_meter.update(5.0, 7, 70)
    assert (count_meter.rate(), meter.rate(5.0)) == (None, None)
    count_meter.update(SILENCE_TIMEOUT + 1, 7, 70)
    assert (count_meter.rate(), meter.rate(SILENCE_TIMEOUT + 1)) == (NO_TRAFFIC, NO_TRAFFIC)


def test_what_came_while_nobody_looked_is_no_rate_of_the_next_second() -> None:
    """A topic of 0.2 Hz had 1 Hz for a page that was opened later."""
    count_meter = CountMeter(0.0, 0, 0)
    for at in [*range(1, 12), *range(33, 60)]:
        count_meter.update(at, at // 5, at // 5 * SIZE)
        rate = count_meter.rate()
        assert rate is None or rate.hz == pytest.approx(0.2), at
    assert rate


def test_looks_that_are_always_far_apart_make_rates() -> None:
    assert looked(10.0, 60, 4.0)[2:] == [pytest.approx(10.0)] * 13


def test_a_number_that_another_connection_has_now() -> None:
    count_meter = CountMeter(0.0, 100, 1000)
    count_meter.update(1.0, 110, 1100)
    count_meter.update(2.0, 3, 30)
    assert count_meter.rate() is None
    count_meter.update(3.0, 8, 80)
    assert count_meter.rate() == Rate(5.0, 50.0)


@pytest.mark.parametrize("hz", [0.1, 0.5, 1.0, 50.0])
def test_what_arrives_has_the_same_rate(hz: float) -> None:
    meter = Meter(0.0)
    assert meter.rate(1.0) is None
    for number in range(1, 500):
        at = number / hz
        meter.add(at, SIZE)
        assert (rate := meter.rate(at + 0.5 / hz)) if number > 1 else meter.rate(at) is None
        assert number == 1 or (rate and rate.hz == pytest.approx(hz) and rate.bytes == pytest.approx(hz * SIZE))
    assert meter.rate(at + 4 / hz + 1) == NO_TRAFFIC
