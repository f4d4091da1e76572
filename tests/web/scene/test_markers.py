"""Markers that add up."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1 import Duration
from pyros1.msgs.geometry_msgs.msg import Point
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.web.scene import markers as markers_of
from pyros1.web.scene.markers import Markers, as_json


def marker(number: int, action: int = 0, lifetime: float = 0.0, ns: str = "n") -> Any:
    return Marker(ns=ns, id=number, action=action, lifetime=Duration.from_sec(lifetime))


def test_they_add_up_change_and_go() -> None:
    markers = Markers()
    markers.apply([marker(1), marker(2)], 0.0)
    version, new, gone = markers.changes(0, 0.0)
    assert ([each["id"] for each in new], gone) == ([1, 2], [])
    markers.apply([marker(2), marker(1, action=2), marker(3)], 1.0)
    version, new, gone = markers.changes(version, 1.0)
    assert (sorted(each["id"] for each in new), gone) == ([2, 3], [["n", 1]])
    assert markers.changes(version, 1.0) == (version, [], [])
    markers.apply([marker(0, action=3, ns="")], 2.0)
    assert sorted(markers.changes(version, 2.0)[2]) == [["n", 2], ["n", 3]]
    assert markers.changes(0, 2.0)[1] == []


def test_a_lifetime_ends() -> None:
    markers = Markers()
    markers.apply([marker(1, lifetime=0.5)], 10.0)
    version, new, _ = markers.changes(0, 10.4)
    assert len(new) == 1
    assert markers.changes(version, 10.5)[2] == [["n", 1]]


def test_a_lifetime_of_next_to_nothing_is_none() -> None:
    markers = Markers()
    markers.apply([marker(1, lifetime=1e-5), marker(2, lifetime=-5.0)], 10.0)
    assert len(markers.changes(0, 20.0)[1]) == 2


def test_a_lifetime_ends_when_time_goes_back() -> None:
    markers = Markers()
    markers.apply([marker(1, lifetime=0.5), marker(2)], 600.0)
    version, _, _ = markers.changes(0, 600.1)
    assert markers.changes(version, 2.0)[2] == [["n", 1]]  # a bag begins again
    markers.apply([marker(3, lifetime=0.5)], 2.0)
    assert [each["id"] for each in markers.changes(version, 1.99)[1]] == [3]


def test_large_ones_make_room_for_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(markers_of, "MAX_BYTES", 1_000_000)
    markers, points = Markers(), [Point()] * 4_000
    for number in range(5):
        large = marker(number)
        large.points = points
        markers.apply([large, marker(100)], 0.0)
    assert [each["id"] for each in markers.changes(0, 0.0)[1]] == [3, 4, 100]
    alone = marker(9)
    alone.text = "x" * 2_000_000
    markers.apply([alone], 0.0)
    assert [each["id"] for each in markers.changes(0, 0.0)[1]] == [9]


@given(st.lists(st.tuples(st.integers(0, 3), st.sampled_from([0, 2, 3, 7]), st.booleans()), max_size=40))
def test_who_looks_now_and_then_knows_the_same_as_who_looks_once(steps: list[tuple[int, int, bool]]) -> None:
    markers, known, seen = Markers(), {}, 0
    for number, action, look in steps:
        markers.apply([marker(number, action, ns="ab"[number % 2])], 0.0)
        if look:
            seen, new, gone = markers.changes(seen, 0.0)
            for key in gone:
                known.pop(tuple(key), None)
            known.update({(each["ns"], each["id"]): each for each in new})
    seen, new, gone = markers.changes(seen, 0.0)
    for key in gone:
        known.pop(tuple(key), None)
    known.update({(each["ns"], each["id"]): each for each in new})
    assert {*known} == {(each["ns"], each["id"]) for each in markers.changes(0, 0.0)[1]}


@pytest.mark.parametrize("number", [float("nan"), float("inf"), 1e31, -1e300])
def test_what_cannot_be_drawn_is_not_said_to_be_0(number: float) -> None:
    for name in ("scale", "pose.position"):
        made = marker(1)
        owner = made.scale if name == "scale" else made.pose.position
        owner.x = number
        assert not as_json(made)["finite"]
    assert as_json(marker(1))["finite"]


@given(st.floats(), st.text())
def test_any_marker_is_json(number: float, text: str) -> None:
    made = marker(1)
    made.text = text
    made.pose.position.x = made.color.r = made.scale.z = number
    json.dumps(as_json(made), allow_nan=False)
