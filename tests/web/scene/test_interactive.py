"""Interactive markers, as their servers tell of them."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.geometry_msgs.msg import Point, Pose
from pyros1.msgs.visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerControl,
    InteractiveMarkerInit,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
    Marker,
    MenuEntry,
)
from pyros1.web.scene import interactive
from pyros1.web.scene.interactive import InteractiveMarkers


def marker(name: str, x: float = 0.0, **more: Any) -> InteractiveMarker:
    made = InteractiveMarker(name=name, **more)
    made.pose.position.x = x
    return made


def init(number: int, *markers: InteractiveMarker, server: str = "s") -> InteractiveMarkerInit:
    return InteractiveMarkerInit(server_id=server, seq_num=number, markers=[*markers])


def update(number: int, **more: Any) -> InteractiveMarkerUpdate:
    return InteractiveMarkerUpdate(server_id="s", seq_num=number, type=1, **more)


def move(name: str, x: float) -> InteractiveMarkerPose:
    pose = Pose()
    pose.position.x = x
    return InteractiveMarkerPose(name=name, pose=pose)


def names(markers: list[dict[str, Any]]) -> list[str]:
    return sorted(each["name"] for each in markers)


def test_points_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interactive, "MAX_POINTS", 1_000)

    def large(name: str, points: int = 400) -> InteractiveMarker:
        return marker(name, controls=[InteractiveMarkerControl(markers=[Marker(points=[Point()] * points)])])

    known = InteractiveMarkers()
    known.init(init(1, large("a"), large("b"), large("c"), marker("small")), 0.0)
    assert names(known.changes(0)[1]) == ["a", "b", "small"]
    known.update(update(2, markers=[large("b", 600), large("a", 500)], erases=["b"]), 0.0)
    known.update(update(3, markers=[large("c")]), 0.0)
    assert names(known.changes(0)[1]) == ["a", "c", "small"]


def test_they_come_move_and_go() -> None:
    known = InteractiveMarkers()
    known.init(init(1, marker("a"), marker("b")), 0.0)
    version, new, moved, gone = known.changes(0)
    assert (names(new), moved, gone) == (["a", "b"], [], [])
    assert known.update(update(2, poses=[move("a", 3.0), move("nobody", 1.0)]), 0.0)
    version, new, moved, gone = known.changes(version)
    assert (new, names(moved), moved[0]["pose"][0], gone) == ([], ["a"], 3.0, [])
    assert known.update(update(3, markers=[marker("c")], erases=["b", "nobody"]), 0.0)
    version, new, moved, gone = known.changes(version)
    assert (names(new), moved, gone) == (["c"], [], [["s", "b"]])
    assert known.changes(version) == (version, [], [], [])
    assert names(known.changes(0)[1]) == ["a", "c"]


def test_a_server_that_tells_all_again_changes_only_what_is_different() -> None:
    known = InteractiveMarkers()
    known.init(init(1, marker("a"), marker("b"), marker("c")), 0.0)
    seen, *_ = known.changes(0)
    known.init(init(1, marker("a"), marker("b"), marker("c")), 0.0)
    assert known.changes(seen) == (seen, [], [], [])
    known.init(init(2, marker("a"), marker("b", 1.0), marker("d")), 0.0)
    _, new, moved, gone = known.changes(seen)
    assert (names(new), names(moved), gone) == (["d"], ["b"], [["s", "c"]])


def test_an_update_that_is_missing_is_noticed() -> None:
    known = InteractiveMarkers()
    assert not known.update(update(1), 0.0)  # before all markers came
    known.init(init(5, marker("a")), 0.0)
    assert known.update(update(5, erases=["a"]), 0.0)  # older: it is in what came
    assert not known.update(update(7, erases=["a"]), 0.0)
    assert names(known.changes(0)[1]) == ["a"]
    alive = InteractiveMarkerUpdate(server_id="s", seq_num=5, type=0)
    assert known.update(alive, 0.0)
    alive.seq_num = 9
    assert not known.update(alive, 0.0)


def test_servers_that_go() -> None:
    known = InteractiveMarkers()
    known.init(init(1, marker("a")), 0.0)
    known.init(init(1, marker("a"), server="other"), 0.0)
    seen, new, *_ = known.changes(0)
    assert len(new) == 2
    known.update(InteractiveMarkerUpdate(server_id="s", seq_num=1, type=0), 8.0)
    known.remove_expired(12.0)
    assert known.changes(seen)[3] == [["other", "a"]]


@given(st.floats(), st.text(), st.integers(0, 255))
def test_any_marker_is_json(number: float, text: str, mode: int) -> None:
    control = InteractiveMarkerControl(name=text, interaction_mode=mode, markers=[Marker(text=text)])
    control.orientation.w = number
    made = marker(text, number, scale=number, description=text, controls=[control])
    made.menu_entries = [MenuEntry(id=1, title=text)]
    known = InteractiveMarkers()
    known.init(init(1, made), 0.0)
    json.dumps(known.changes(0), allow_nan=False)
