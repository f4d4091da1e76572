"""The pure part of filters; stock: interop/modules/test_filters.py."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.filters import ApproximateTime, ExactTime, Recent
from pyros1.filters.synchronizers import make_matcher, stamp_of
from pyros1.ground.timing import Time
from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.msgs.std_msgs.msg import String


def at(*milliseconds: int) -> list[Time]:
    return [Time(0, each * 1_000_000) for each in milliseconds]


def feed(sync: ExactTime, *given: tuple[int, int]) -> list[tuple[Any, ...]]:
    """Put in (topic, stamp in ms), with names of both as messages."""
    return [each for index, ms in given for each in sync.add(index, at(ms)[0], f"{'abc'[index]}{ms}")]


def test_equal_stamps() -> None:
    assert feed(ExactTime(2, 10), (0, 5), (0, 6), (1, 7), (1, 6), (1, 5)) == [("a6", "b6"), ("a5", "b5")]


def test_the_oldest_go_first() -> None:
    assert feed(ExactTime(2, 2), (0, 5), (0, 7), (0, 6), (1, 5), (1, 6)) == [("a6", "b6")]


def test_the_nearest_stamps() -> None:
    assert feed(ApproximateTime(2, 10, 0.01), (0, 5), (0, 12), (1, 11)) == [("a12", "b11")]
    assert feed(ApproximateTime(2, 10, 0.01), (0, 5), (1, 15)) == []
    assert feed(ApproximateTime(3, 10, 0.01), (0, 5), (1, 22), (1, 14), (2, 13)) == [("a5", "b14", "c13")]
    assert feed(ApproximateTime(2, 10, 0), (0, 5), (1, 5)) == []


def test_many_messages_that_do_not_fit_take_little_time() -> None:
    """Each of five topics has a hundred near the newest, but no two topics have stamps near each other."""
    sync = ApproximateTime(6, 100, 0.1)
    for index in range(5):
        for number in range(100):
            sync.add(index, at(1000 + 95 * (index % 2) * 2 + number % 5 + index)[0], "")
    assert sync.add(5, at(1100)[0], "") == []


def test_recent_messages_are_sorted() -> None:
    recent = Recent(3)
    assert recent.oldest is None and recent.before(Time(9)) is None
    for ms in (1, 5, 3, 4):
        recent.add(at(ms)[0], ms)
    assert [recent.oldest, recent.newest] == at(3, 5)
    assert recent.between(*at(3, 4)) == [3, 4]
    assert [recent.after(each) for each in at(2, 4, 6)] == [3, 4, None]
    assert [recent.before(each) for each in at(2, 4, 6)] == [None, 4, 5]


def test_stamps() -> None:
    joy = Joy()
    joy.header.stamp = Time(5)
    assert stamp_of(joy) == Time(5)
    assert stamp_of(String(), Time(7)) == Time(7)
    with pytest.raises(TypeError, match="std_msgs/String has no header"):
        stamp_of(String())
    assert type(make_matcher(2, 5, None)) is ExactTime
