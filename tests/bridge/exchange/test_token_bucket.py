"""How often something may be done."""

from __future__ import annotations

from pyros1.bridge.exchange.token_bucket import TokenBucket


def test_a_burst_and_then_a_rate() -> None:
    token_bucket = TokenBucket(2.0, 3)
    assert [token_bucket.take(10.0) for _ in range(5)] == [True, True, True, False, False]
    assert (
        not token_bucket.take(10.4)
        and token_bucket.take(10.5)
        and not token_bucket.take(10.9)
        and token_bucket.take(11.0)
    )
    assert [token_bucket.take(100.0) for _ in range(5)].count(True) == 3


def test_what_counts_as_more() -> None:
    token_bucket = TokenBucket(10.0, 100)
    assert token_bucket.take(0.0)
    token_bucket.charge(149)
    assert not token_bucket.take(4.9) and token_bucket.take(5.15) and not token_bucket.take(5.17)
