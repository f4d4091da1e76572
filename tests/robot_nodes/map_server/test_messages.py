from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.map_server.errors import MapDataError
from pyros1.robot_nodes.map_server.messages import make_grid, read_grid

CELLS = np.array([[0, 100, -1], [1, 2, 3]], np.int8)


@given(st.tuples(st.floats(-100, 100), st.floats(-100, 100), st.floats(-3.1, 3.1)))
def test_there_and_back(origin: tuple[float, float, float]) -> None:
    grid = make_grid(CELLS, 0.5, origin)
    assert (grid.info.width, grid.info.height, list(grid.data)) == (3, 2, [0, 100, -1, 1, 2, 3])
    cells, found = read_grid(grid)
    assert np.array_equal(cells, CELLS)
    assert found == pytest.approx(origin)


def test_a_map_without_orientation() -> None:
    grid = make_grid(CELLS, 0.5, (1.0, 2.0, 1.0))
    rotation = grid.info.origin.orientation
    rotation.x = rotation.y = rotation.z = rotation.w = 0.0
    assert read_grid(grid)[1] == (1.0, 2.0, 0.0)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda grid: setattr(grid, "data", [0] * 5), "5 cells instead of 3 x 2"),
        (lambda grid: setattr(grid.info, "width", 2), "6 cells instead of 2 x 2"),
        (lambda grid: (setattr(grid, "data", []), setattr(grid.info, "width", 0)), "0 cells instead of 0 x 2"),
        (lambda grid: setattr(grid.info, "resolution", float("nan")), "is not a number"),
        (lambda grid: setattr(grid.info.origin.position, "y", float("inf")), "is not a number"),
        (lambda grid: setattr(grid.info.origin.orientation, "x", float("nan")), "is not a number"),
        (lambda grid: setattr(grid.info.origin.orientation, "x", float("inf")), "is not a number"),
    ],
)
def test_maps_that_are_none(change: Any, problem: str) -> None:
    grid = make_grid(CELLS, 0.5, (0.0, 0.0, 0.0))
    change(grid)
    with pytest.raises(MapDataError, match=problem):
        read_grid(grid)


@pytest.mark.parametrize("factor", [1e-200, 1e-3, 7.0, 1e200])
def test_an_orientation_of_any_length(factor: float) -> None:
    grid = make_grid(CELLS, 0.5, (1.0, 2.0, 0.7))
    rotation = grid.info.origin.orientation
    rotation.z, rotation.w = rotation.z * factor, rotation.w * factor
    assert read_grid(grid)[1] == pytest.approx((1.0, 2.0, 0.7))
