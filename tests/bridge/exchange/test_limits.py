"""What other sites may ask for how often."""

from __future__ import annotations

from pyros1.bridge.exchange.limits import Limits


def test_limits_outlast_runs_of_a_site() -> None:
    limits = Limits()
    assert [limits.of("red", ()).probes.take(0.0) for _ in range(200)].count(True) == 100
    assert not limits.of("red", ()).probes.take(0.0) and limits.of("blue", ()).probes.take(0.0)


def test_sites_that_are_gone_are_forgotten_in_the_end() -> None:
    limits = Limits()
    red, gone = limits.of("red", ["red"]), limits.of("gone", ["red"])
    for number in range(5000):
        limits.of(f"site{number}", ["red"])
    assert limits.of("red", ["red"]) is red and limits.of("gone", ["red"]) is not gone
