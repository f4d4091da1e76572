"""What hztest makes of the times at which messages came (L186)."""

from __future__ import annotations

import pytest

from pyros1.test_nodes.common import FailedError
from pyros1.test_nodes.hz import Meter


def check_rate(meter: Meter, *times: float) -> str:
    for now in times:
        meter.add(now)
    try:
        meter.check_rate()
    except FailedError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    ("hz", "hzerror", "times", "said"),
    [
        (10, 1, (5.0, 5.1, 5.2, 5.3), ""),
        (10, 1, (5.0, 5.2, 5.4), "below the minimum of 9.000 Hz"),
        (10, 1, (5.0, 5.05, 5.1), "above the maximum of 11.000 Hz"),
        (10, 1, (5.0, 5.01, 5.2), ""),
        (10, 1, (5.0,), "one message"),
        (10, 1, (), "no messages"),
        (10, 1, (0.0, 0.0), "no messages"),
        (10, 1, (9.0, 5.0, 5.1, 5.2), ""),
        (1, 2, (5.0, 9.0), ""),
        (0, 0, (), ""),
        (0, 0, (5.0,), "1 arrived"),
    ],
)
def test_the_mean_rate(hz: float, hzerror: float, times: tuple[float, ...], said: str) -> None:
    """Time that is 0 does not run yet; where it jumps back, counting begins anew."""
    found = check_rate(Meter(hz, hzerror), *times)
    assert said in found and bool(said) == bool(found)


@pytest.mark.parametrize(
    ("hzerror", "times", "said"),
    [
        (1, (5.0, 5.1, 5.2), ""),
        (1, (5.0, 5.01, 5.2), "0.010000 s is too short"),
        (1, (5.0, 5.15, 5.2), "0.150000 s is too long"),
        (10, (5.0, 9.0), ""),
    ],
)
def test_every_interval(hzerror: float, times: tuple[float, ...], said: str) -> None:
    found = check_rate(Meter(10, hzerror, check_intervals=True), *times)
    assert said in found and bool(said) == bool(found)
