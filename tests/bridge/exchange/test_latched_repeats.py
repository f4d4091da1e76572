"""Commands that latching publishers repeat when a bridge subscribes again."""

from __future__ import annotations

from pyros1.bridge.exchange.latched_repeats import LatchedRepeats, Source

GOAL: Source = ("/goal", None)


def test_the_first_message_after_each_subscription_is_a_repetition() -> None:
    repeats = LatchedRepeats()
    repeats.on_subscribe(GOAL)
    assert [repeats.take(GOAL, publisher, "", 1.0) for publisher in ("/a", "/a", "/b")] == [False] * 3
    repeats.on_subscribe(GOAL)
    assert not repeats.take(("/other", None), "/a", "", 2.0) and not repeats.take(GOAL, "/new", "", 2.0)
    assert [repeats.take(GOAL, publisher, "", 2.0) for publisher in ("/a", "/a", "/b")] == [True, False, True]
    repeats.on_subscribe(GOAL)
    assert [repeats.take(GOAL, publisher, "", 3.0) for publisher in ("/a", "/b", "/new")] == [True] * 3


def test_publishers_that_are_gone_are_forgotten() -> None:
    repeats = LatchedRepeats()
    for publisher, now in (("/gone", 1.0), ("/here", 1.0), ("/new", 3.0)):
        repeats.take(GOAL, publisher, "", now)
    repeats.on_subscribe(GOAL)
    repeats.drop_publishers({"/goal": ["/here"]}, asked_at=2.0)
    assert [repeats.take(GOAL, publisher, "", 4.0) for publisher in ("/gone", "/here", "/new")] == [False, True, True]
    repeats.drop_publishers({}, asked_at=5.0)
    repeats.on_subscribe(GOAL)
    assert [repeats.take(GOAL, publisher, "", 6.0) for publisher in ("/gone", "/here", "/new")] == [False] * 3


def test_a_node_that_was_killed_and_started_again_repeats_nothing() -> None:
    repeats = LatchedRepeats()
    for publisher in ("/a", "/b", "/c", "/d"):
        assert not repeats.take(GOAL, publisher, f"http://host:1{publisher}", 1.0)
    assert not repeats.take(GOAL, "/d", "http://host:2/d", 1.5)
    repeats.on_subscribe(GOAL)
    assert repeats.take(GOAL, "/a", "http://host:1/a", 2.0), "the same process"
    assert not repeats.take(GOAL, "/b", "http://host:2/b", 2.0)
    assert repeats.take(GOAL, "/c", "", 2.0), "not known: a command that was carried out must not be repeated"
    assert repeats.take(GOAL, "/d", "http://host:2/d", 2.0)
    repeats.on_subscribe(GOAL)
    assert repeats.take(GOAL, "/b", "http://host:2/b", 3.0) and not repeats.take(GOAL, "/b", "http://host:2/b", 3.0)


def test_only_the_newest_publishers_are_remembered() -> None:
    repeats = LatchedRepeats()
    for number in range(1001):
        repeats.take(GOAL, f"/n{number}", "", 1.0)
    repeats.on_subscribe(GOAL)
    assert [repeats.take(GOAL, f"/n{number}", "", 2.0) for number in (0, 1, 1000)] == [False, True, True]
