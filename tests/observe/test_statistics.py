"""The figures and lines of hz, bw and delay (L64-L66)."""

from __future__ import annotations

from pyros1.observe.statistics import (
    BandwidthMeter,
    DelayMeter,
    RateMeter,
    rate_lines,
    rate_table,
    size_lines,
    summarise,
)


def test_hz_lines() -> None:
    meter = RateMeter()
    for number in range(5):
        meter.add(100.0 + 0.1 * number)
    measurement = meter.measurement()
    assert measurement is not None
    assert rate_lines(*measurement) == "average rate: 10.000\n\tmin: 0.100s max: 0.100s std dev: 0.00000s window: 5"
    assert meter.measurement() is None  # nothing new


def test_hz_needs_two_messages_and_starts_anew_when_time_jumps_back() -> None:
    meter = RateMeter()
    meter.add(10.0)
    assert meter.measurement() is None
    meter.add(11.0)
    meter.add(1.0)
    meter.add(1.5)
    measurement = meter.measurement()
    assert measurement is not None and measurement[0] == 2.0 and measurement[2] == 2


def test_hz_window_counts_messages() -> None:
    meter = RateMeter(3)
    for moment in (0.0, 5.0, 6.0, 7.0):
        meter.add(moment)
    measurement = meter.measurement()
    assert measurement is not None and measurement[0] == 1.0 and measurement[2] == 3


def test_hz_table_has_the_stock_columns() -> None:
    summary = summarise([0.1, 0.1])
    table = rate_table({"/chatter": (10.0, summary._replace(minimum=0.09711, maximum=0.1028, deviation=0.001346), 10)})
    assert table == (
        " topic     rate   min_delta   max_delta   std_dev    window\n"
        "===========================================================\n"
        "/chatter   10.0   0.09711     0.1028      0.001346   10    \n"
    )
    assert "1.234e+03   " in rate_table({"/fast": (1234.4, summary, 10)})


def test_bw_lines_scale_by_thousands() -> None:
    meter = BandwidthMeter()
    assert meter.lines(0.0) is None
    meter.add(0.0, 1_000_000)
    meter.add(1.0, 3_000_000)
    assert meter.lines(2.0) == "average: 2.00MB/s\n\tmean: 2.00MB min: 1.00MB max: 3.00MB window: 2"
    assert size_lines([500, 1500], 0.5) == "average: 4.00KB/s\n\tmean: 1.00KB min: 0.50KB max: 1.50KB window: 2"


def test_bandwidth_of_bursts_is_that_of_a_second() -> None:
    told, meter = BandwidthMeter(100), BandwidthMeter()
    for number in range(3000):  # 1000 messages at once, each second
        for each in (told, meter):
            each.add(float(number // 1000), 10)
    assert str(meter.lines(3.0)).startswith("average: 10.00KB/s\n") and str(meter.lines(3.0)).endswith("window: 2000")
    assert str(told.lines(3.0)).startswith("average: 1.00KB/s\n")


def test_delay_lines() -> None:
    meter = DelayMeter()
    assert meter.lines() is None
    meter.add(0.5)
    meter.add(1.5)
    assert meter.lines() == "average delay: 1.000\n\tmin: 0.500s max: 1.500s std dev: 0.50000s window: 2"
    assert meter.lines() is None
