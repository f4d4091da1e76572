"""Sites that hold up others get packets of their own, for a time that grows."""

from __future__ import annotations

from pyros1.bridge.exchange.slow_sites import FIRST_TIME, LONGEST_TIME, OVERLAP, SlowSites

KNOWN = ("base", "blue")


def test_for_some_time() -> None:
    slow = SlowSites()
    assert slow.separate == frozenset() and not slow.is_flagged("blue", 0.0)
    slow.add("blue", 0.0)
    assert slow.separate == {"blue"} and slow.is_flagged("blue", 0.0) and not slow.is_flagged("base", 0.0)
    assert not slow.tick(FIRST_TIME - 1, KNOWN) and slow.is_flagged("blue", FIRST_TIME - 1)
    assert not slow.tick(FIRST_TIME, KNOWN) and not slow.is_flagged("blue", FIRST_TIME)
    assert slow.separate == {"blue"}, "until it listens to what is for all"
    assert slow.tick(FIRST_TIME + OVERLAP, KNOWN) and slow.separate == frozenset()


def test_the_time_grows() -> None:
    slow, now, times = SlowSites(), 0.0, []
    for _ in range(8):
        slow.add("blue", now)
        slow.add("blue", now + 1)  # known already
        start = now
        while slow.separate:
            now += 1
            slow.tick(now, KNOWN)
        times.append(now - start - OVERLAP)
    assert times[:3] == [FIRST_TIME, 2 * FIRST_TIME, 4 * FIRST_TIME] and times[-1] == LONGEST_TIME


def test_slow_again_in_the_overlap() -> None:
    slow = SlowSites()
    slow.add("blue", 0.0)
    slow.add("blue", FIRST_TIME + 1)
    assert slow.is_flagged("blue", FIRST_TIME + 1) and not slow.tick(FIRST_TIME + OVERLAP, KNOWN)


def test_sites_that_are_gone_are_forgotten() -> None:
    slow = SlowSites()
    slow.add("blue", 0.0)
    assert slow.tick(1.0, ("base",)) and slow.separate == frozenset()
    slow.add("blue", 2.0)
    assert slow.is_flagged("blue", 2.0 + FIRST_TIME - 1) and not slow.is_flagged("blue", 2.0 + FIRST_TIME)
