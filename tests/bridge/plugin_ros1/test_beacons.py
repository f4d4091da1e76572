"""Beacons: when to send them, what is there, and when it is gone."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from pyros1.bridge.plugin_ros1 import beacons
from pyros1.bridge.plugin_ros1.beacons import LOSS_TIME, HeardBeacons, OwnBeacons
from pyros1.bridge.plugin_ros1.keys import Kind, Resource, beacon_key

MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"


def resource(name: str, kind: Kind = Kind.PUBLISHER) -> Resource:
    return Resource(kind, "std_msgs/String", MD5, "*", name)


CHATTER = resource("/chatter")
KEY = beacon_key(CHATTER)


def ticks(own: OwnBeacons, start: float, end: float) -> Iterator[float]:
    """Yield the times at which a beacon is sent."""
    for number in range(int(start * 10), int(end * 10)):
        yield from (number / 10 for _ in own.tick(number / 10))


def test_a_beacon_each_second() -> None:
    own = OwnBeacons(lambda: 0.0)
    own.set_announced([CHATTER], 0.0)
    assert [*ticks(own, 0, 3.5)] == [0.0, 1.0, 2.0, 3.0]
    assert own.tick(9.0) == [KEY] and own.tick(9.5) == [] and own.tick(10.0) == [KEY], "after a pause, only one"
    own.set_announced([], 10.0)
    assert own.tick(11.0) == []


def test_what_goes_on_is_not_announced_anew() -> None:
    own = OwnBeacons(lambda: 0.0)
    own.set_announced([CHATTER], 0.0)
    own.tick(0.0)
    own.set_announced([CHATTER, resource("/other")], 0.5)
    assert own.tick(0.5) == [beacon_key(resource("/other"))]


def test_who_hears_the_same_beacon_may_stop_and_starts_again_after_silence() -> None:
    numbers = iter([0.6, 0.4, 0.3])  # goes on; stops; waits for 0.3 s
    own = OwnBeacons(lambda: next(numbers))
    own.set_announced([CHATTER], 0.0)
    for second in range(4):
        own.on_beacon(KEY)
        sent = [*ticks(own, second, second + 1)]
        assert sent == ([second] if second < 2 else [])
    # At 3 s it has heard one since the last look, at 4 s it has not.
    assert [*ticks(own, 4, 7)] == [4.3, 5.3, 6.3]


def test_who_hears_one_while_it_waits_stays_silent() -> None:
    numbers = iter([0.0, 0.9, 0.0])
    own = OwnBeacons(lambda: next(numbers))
    own.set_announced([CHATTER], 0.0)
    own.on_beacon(KEY)
    assert [*ticks(own, 0, 2.2)] == [0.0]
    own.on_beacon(KEY)
    assert [*ticks(own, 2.2, 3.0)] == []
    own.on_beacon("unknown")


@pytest.mark.parametrize("seed", range(20))
def test_bridges_that_take_turns_are_never_silent_for_long(seed: int) -> None:
    chance = random.Random(seed)
    bridges = [OwnBeacons(chance.random) for _ in range(4)]
    heard = HeardBeacons(lambda _: True)
    starts = [chance.random() for _ in bridges]
    sent = 0
    for tick in range(600):
        now = tick / 10
        for number, own in enumerate(bridges):
            if now >= starts[number]:
                own.set_announced([CHATTER], now)
            if number == 0 and now > 30:
                continue  # it has died
            for key in own.tick(now):
                sent += 1
                heard.on_beacon(key, now)
                for other in bridges:
                    if other is not own:
                        other.on_beacon(key)
        heard.expire(now)
        assert now < 2 or heard.used == [CHATTER]
    assert sent < 150, "most are silent"


def test_what_is_announced_is_there_until_its_beacons_end() -> None:
    heard = HeardBeacons(lambda each: each.name != "/other")
    assert heard.on_beacon(KEY, 10.0)
    assert not heard.on_beacon(KEY, 12.0) and heard.used == [CHATTER]
    assert not heard.on_beacon(beacon_key(resource("/other")), 12.0)
    assert not heard.expire(12.0 + LOSS_TIME) and heard.used == [CHATTER] and heard.unused == [resource("/other")]
    assert not heard.on_beacon(beacon_key(resource("/other")), 15.0)
    assert heard.expire(12.1 + LOSS_TIME) and heard.used == [] and len(heard.unused) == 1
    assert not heard.expire(30.0), "nothing that is used"
    assert heard.unused == [] and heard.on_beacon(KEY, 31.0)


def test_what_is_ignored() -> None:
    heard = HeardBeacons(lambda _: True)
    assert not heard.on_beacon(beacon_key(resource("/a", Kind.SUBSCRIBER)), 1.0)
    assert not heard.on_beacon("ros1_discovery_info/*/sub/2a/*/*/odom", 1.0) and heard.ignored == {}
    assert not heard.on_beacon("ros1_discovery_info/*/pub/2a/*/*/odom", 1.0)
    assert heard.ignored == {"beacons that cannot be understood": 1} and heard.used == []


def test_a_flood_of_names_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beacons, "MAX_RESOURCES", 3)
    heard = HeardBeacons(lambda each: each.name.startswith("/used"))
    for number in range(5):
        heard.on_beacon(beacon_key(resource(f"/flood{number}")), 1.0)
    for number in range(5):
        assert heard.on_beacon(beacon_key(resource(f"/used{number}")), 1.0) is (number < 3)
    assert len(heard.unused) == len(heard.used) == 3
    assert heard.ignored == {"beacons of too many topics and services": 4}
