"""How often something may be done."""

from __future__ import annotations

from pyros1.bridge.exchange.allowance import Allowance


def test_a_burst_and_then_a_rate() -> None:
    allowance = Allowance(2.0, 3)
    assert [allowance.take(10.0) for _ in range(5)] == [True, True, True, False, False]
    assert not allowance.take(10.4) and allowance.take(10.5) and not allowance.take(10.9) and allowance.take(11.0)
    assert [allowance.take(100.0) for _ in range(5)].count(True) == 3


def test_what_counts_as_more() -> None:
    allowance = Allowance(10.0, 100)
    assert allowance.take(0.0)
    allowance.charge(149)
    assert not allowance.take(4.9) and allowance.take(5.15) and not allowance.take(5.17)
