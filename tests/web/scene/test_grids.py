"""Occupancy grids and what changes in them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.map_msgs.msg import OccupancyGridUpdate
from pyros1.msgs.nav_msgs.msg import OccupancyGrid
from pyros1.web.scene.grids import Grid
from pyros1.web.scene.shape import ShapeError


def grid(width: int, height: int) -> OccupancyGrid:
    message = OccupancyGrid(data=[0] * (width * height))
    message.info.width, message.info.height, message.info.resolution = width, height, 1.0
    return message


def update(x: int, y: int, width: int, height: int, value: int = 100) -> OccupancyGridUpdate:
    return OccupancyGridUpdate(x=x, y=y, width=width, height=height, data=[value] * (width * height))


def test_the_whole_and_then_its_parts() -> None:
    known = Grid()
    assert known.take() is None
    known.update(update(0, 0, 1, 1))  # of nothing
    known.put(grid(4, 3))
    shape = known.take()
    assert shape is not None
    assert (shape[0]["kind"], shape[0]["width"], len(shape[1])) == ("map", 4, 12)
    assert known.take() is None
    known.update(update(1, 0, 2, 1, 7))
    known.update(update(3, 1, 1, 1, 8))
    shape = known.take()
    assert shape is not None
    assert shape[0] == {"kind": "patch", "x": 1, "y": 0, "width": 3, "height": 2}
    assert [*shape[1]] == [7, 7, 0, 0, 0, 8]
    known.resend()
    shape = known.take()
    assert shape is not None
    assert [*shape[1]] == [0, 7, 7, 0, 0, 0, 0, 8, 0, 0, 0, 0]


@pytest.mark.parametrize("wrong", [update(3, 0, 2, 1), update(-1, 0, 1, 1), update(0, 2, 1, 2), update(0, 0, 9, 9)])
def test_updates_that_leave_the_map(wrong: OccupancyGridUpdate) -> None:
    known = Grid()
    known.put(grid(4, 3))
    with pytest.raises(ShapeError, match="exceeds the map"):
        known.update(wrong)


def test_updates_that_contradict_themselves() -> None:
    known = Grid()
    known.put(grid(4, 3))
    with pytest.raises(ShapeError, match="has 1 values"):
        known.update(OccupancyGridUpdate(width=2, height=2, data=[1]))


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4), st.integers(0, 4), st.integers(0, 4), st.booleans())))
def test_who_looks_now_and_then_sees_the_same(steps: list[tuple[int, int, int, int, bool]]) -> None:
    known, seen = Grid(), np.zeros((5, 5), np.int8)
    known.put(grid(5, 5))
    known.take()
    for number, (x, y, width, height, look) in enumerate(steps):
        known.update(update(x, y, min(width, 5 - x), min(height, 5 - y), number % 100))
        if look:
            paint(seen, known)
    paint(seen, known)
    known.resend()
    whole = known.take()
    assert whole is not None
    assert seen.tobytes() == whole[1]


def paint(seen: np.ndarray, known: Grid) -> None:  # type: ignore[type-arg]
    shape = known.take()
    if shape is not None:
        facts, cells = shape
        x, y, width, height = (facts[name] for name in ("x", "y", "width", "height"))
        seen[y : y + height, x : x + width] = np.frombuffer(cells, np.int8).reshape(height, width)
