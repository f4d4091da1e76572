"""tf.tree: interpolation, loops, and paths between frames."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.tf import Buffer, LookupException
from pyros1.tf.transformations import quaternion_from_euler

from .test_buffer import stamped, x_of


def make(*links: Any) -> Buffer:
    """Return a buffer with links: parent, child, seconds, and perhaps x and the rotation."""
    buffer = Buffer()
    for link in links:
        buffer.set_transform(stamped(*link), "test")
    return buffer


def test_opposite_quaternions_are_the_same_rotation() -> None:
    """Half way between two rotations about z, given with opposite signs, is the one between, not the far one."""
    near, far = quaternion_from_euler(0, 0, 0.2), -quaternion_from_euler(0, 0, 0.6)
    buffer = make(("a", "b", 1.0, 0.0, near), ("a", "b", 2.0, 0.0, far))
    rotation = buffer.lookup_transform("a", "b", Time.from_sec(1.5)).transform.rotation
    found = (rotation.x, rotation.y, rotation.z, rotation.w)
    assert found == pytest.approx(tuple(quaternion_from_euler(0, 0, 0.4)))


def test_between_two_parents_a_frame_is_where_it_was() -> None:
    buffer = make(("a", "b", 0.5, 3.0), ("a", "c", 1.0, 1.0), ("b", "c", 2.0, 7.0), ("a", "b", 2.5, 3.0))
    assert x_of(buffer.lookup_transform("a", "c", Time.from_sec(1.9))) == 1.0
    assert x_of(buffer.lookup_transform("a", "c", Time.from_sec(2.0))) == 10.0


@pytest.mark.parametrize(("target", "source"), [("a", "x"), ("x", "a")])
def test_a_loop_is_an_error(target: str, source: str) -> None:
    buffer = make(("a", "b", 1.0), ("b", "c", 1.0), ("c", "a", 1.0), ("w", "x", 1.0))
    with pytest.raises(LookupException, match="loop"):
        buffer.get_latest_common_time(target, source)
    with pytest.raises(LookupException, match="loop"):
        buffer.lookup_transform(target, source, Time.from_sec(1.0))


def test_a_frame_that_is_found_before_a_loop_closes_is_no_error() -> None:
    buffer = make(("a", "b", 1.0, 1.0), ("b", "c", 1.0, 1.0), ("c", "a", 1.0, 1.0))
    assert x_of(buffer.lookup_transform("a", "c", Time.from_sec(1.0))) == 2.0
    assert buffer.get_latest_common_time("a", "c") == Time.from_sec(1.0)


def test_the_common_time_of_a_frame_with_itself_is_its_latest() -> None:
    buffer = make(("a", "b", 1.0), ("a", "b", 3.0))
    assert buffer.get_latest_common_time("b", "b") == Time.from_sec(3.0)


def test_the_common_time_of_two_branches_is_that_of_the_older_one() -> None:
    links = [("root", "left", 1.0), ("left", "hand", 5.0), ("root", "right", 3.0)]
    buffer = make(*links)
    assert buffer.get_latest_common_time("right", "hand") == Time.from_sec(1.0)
    assert buffer.get_latest_common_time("hand", "right") == Time.from_sec(1.0)
    assert buffer.get_latest_common_time("right", "root") == Time.from_sec(3.0)
    buffer.set_transform_static(stamped("root", "fixed", 0.0), "test")
    assert buffer.get_latest_common_time("fixed", "right") == Time.from_sec(3.0)
    assert buffer.get_latest_common_time("right", "fixed") == Time.from_sec(3.0)


def test_a_frame_can_always_be_transformed_to_itself() -> None:
    buffer = make(("a", "b", 1.0))
    assert buffer.can_transform("b", "b", Time.from_sec(9.0))
    assert not buffer.can_transform("a", "b", Time.from_sec(9.0))


def test_a_frame_in_itself_has_the_time_that_is_asked_for() -> None:
    buffer = make(("a", "b", 3.0))
    assert buffer.lookup_transform("b", "b", Time.from_sec(1.0)).header.stamp == Time.from_sec(1.0)
    assert buffer.lookup_transform("b", "b", Time()).header.stamp == Time.from_sec(3.0)


@pytest.mark.parametrize(("times", "rate"), [([1.0], 0.0), ([1.0, 1.5], 2.0), ([1.0, 1.25, 1.5, 2.0], 3.0)])
def test_the_rate_of_transforms(times: list[float], rate: float) -> None:
    (child,) = [state for state in make(*(("a", "b", time) for time in times)).states() if state.name == "b"]
    assert child.rate == rate
