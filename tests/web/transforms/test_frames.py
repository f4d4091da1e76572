"""The tree of coordinate frames."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from pyros1 import Time
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.web.transforms.frames import MAX_FRAMES, Frames

NAMES = st.sampled_from("abcdef")


def transform(parent: str, child: str, stamp: float = 0.0) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.header.stamp = Time.from_sec(stamp)
    message.transform.rotation.w = 1.0
    return message


def by_name(frames: Frames, now: float) -> dict[str, Any]:
    return {frame["name"]: frame for frame in frames.describe(now)["frames"]}


def test_rates_ages_and_roots() -> None:
    frames = Frames()
    for number in range(11):
        frames.add([transform("map", "odom", number / 10)], "/slam", False, number / 10)
    frames.add([transform("/odom", "/base")], "/robot", True, 0.5)
    told = frames.describe(1.25)
    assert told["roots"] == ["map"]
    odom, base = by_name(frames, 1.25)["odom"], by_name(frames, 1.25)["base"]
    assert (odom["parent"], odom["publishers"], odom["static"], odom["problem"]) == ("map", ["/slam"], False, "")
    assert abs(odom["hz"] - 10) < 1e-6
    assert abs(odom["age"] - 0.25) < 1e-6
    assert (base["parent"], base["static"], base["hz"], base["age"]) == ("odom", True, None, None)
    assert by_name(frames, 9.0)["odom"]["hz"] == 0.0  # it has stopped


def test_two_parents_are_a_fault_while_both_are_told() -> None:
    frames = Frames()
    frames.add([transform("map", "base")], "/one", False, 1.0)
    frames.add([transform("odom", "base")], "/two", False, 2.0)
    base = by_name(frames, 3.0)["base"]
    assert base["problem"] == "has 2 parents: map, odom; a frame can have only one"
    assert base["publishers"] == ["/one", "/two"]
    assert by_name(frames, 6.5)["base"]["problem"] == ""  # the first has changed its mind


def test_a_circle_is_a_fault() -> None:
    frames = Frames()
    frames.add([transform("a", "b"), transform("b", "a"), transform("a", "c")], "/x", False, 0.0)
    told = by_name(frames, 0.0)
    assert told["b"]["problem"] == "is its own ancestor"
    assert "loop" in told["c"]["problem"]
    assert frames.describe(0.0)["roots"] == []


@given(st.lists(st.tuples(NAMES, NAMES, st.booleans()), max_size=60))
def test_any_tree_is_described(told: list[tuple[str, str, bool]]) -> None:
    frames = Frames()
    for number, (parent, child, static) in enumerate(told):
        frames.add([transform(parent, child)], "/x", static, float(number))
    described = frames.describe(float(len(told)))
    names = {frame["name"] for frame in described["frames"]}
    assert names == {child for _, child, _ in told}
    assert not names & {*described["roots"]}


def test_when_time_goes_back_all_begins_anew_but_what_is_static() -> None:
    frames = Frames()
    frames.add([transform("base", "laser")], "/robot", True, 100.0)
    frames.add([transform("map", "gone", 101.0)], "/old", False, 101.0)
    for number in range(11):
        frames.add([transform("map", "odom", 109 + number / 10)], "/slam", False, 109 + number / 10)
    for number in range(5):
        frames.add([transform("world", "odom", 3 + number / 10)], "/other", False, 3 + number / 10)
    told = by_name(frames, 3.5)
    assert {*told} == {"laser", "odom"}
    odom = told["odom"]
    assert (round(odom["hz"], 6), round(odom["age"], 6)) == (10, 0.1)
    assert (odom["publishers"], odom["problem"]) == (["/other"], "")
    frames.add([transform("base", "camera")], "/robot", True, 1.0)  # which had come before
    assert {*by_name(frames, 3.5)} == {"camera", "laser", "odom"}
    assert {*by_name(frames, 1.0)} == {"camera", "laser"}  # again, and nothing has come yet


def test_too_many_frames_are_counted_only() -> None:
    frames = Frames()
    frames.add([transform("map", str(number)) for number in range(MAX_FRAMES + 5)], "/x", False, 0.0)
    told = frames.describe(0.0)
    assert (len(told["frames"]), told["ignored"]) == (MAX_FRAMES, 5)
