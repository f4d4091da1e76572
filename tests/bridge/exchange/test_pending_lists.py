"""Lists of other sites that wait."""

from __future__ import annotations

from pyros1.bridge.exchange.pending_lists import PendingLists
from pyros1.bridge.protocol.packets import Kind


def test_only_the_newest_is_applied_when_they_come_often() -> None:
    lists = PendingLists()
    applied = []
    for number in range(100):
        now = number / 50
        lists.put(Kind.OFFER, [number])
        applied += [(kind, *entries) for kind, entries in lists.take(now)]
    assert applied == [(Kind.OFFER, number) for number in (0, 1, 2, 50)]
    lists.put(Kind.REQUEST, ["r"])
    assert lists.take(2.0) == [(Kind.OFFER, [99]), (Kind.REQUEST, ["r"])] and lists.take(9.0) == []


def test_lists_of_an_earlier_run_are_forgotten() -> None:
    lists = PendingLists()
    lists.put(Kind.OFFER, [1])
    lists.clear()
    assert lists.take(0.0) == []
