from __future__ import annotations

from math import cos, hypot, inf, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pyros1.robot_nodes.flat_world.walls import Walls, chebyshev_distances

RESOLUTION, ORIGIN = 0.25, (-1.0, 2.0)
SLACK = 1e-6
GRIDS = st.tuples(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.1, 0.4]))


def make_grid(height: int, width: int, seed: int, share: float) -> np.ndarray:
    return np.random.default_rng(seed).random((height, width)) < share


def boxes(occupied: np.ndarray, grown: float) -> list[tuple[float, float, float, float]]:
    """Return the sides of all occupied cells, and of the cells around the grid."""
    padded = np.pad(occupied, 1, constant_values=True)
    return [
        (
            ORIGIN[0] + (column - 1) * RESOLUTION - grown,
            ORIGIN[0] + column * RESOLUTION + grown,
            ORIGIN[1] + (row - 1) * RESOLUTION - grown,
            ORIGIN[1] + row * RESOLUTION + grown,
        )
        for row, column in np.argwhere(padded).tolist()
    ]


def cast_slowly(sides: list[tuple[float, float, float, float]], x: float, y: float, angle: float) -> float:
    """Return the distance to the first of all boxes."""
    nearest = inf
    for left, right, low, high in sides:
        enter, leave = 0.0, inf
        for start, heading, near, far in ((x, cos(angle), left, right), (y, sin(angle), low, high)):
            if abs(heading) < 1e-12:
                if not near <= start <= far:
                    leave = -1.0
                continue
            ends = sorted([(near - start) / heading, (far - start) / heading])
            enter, leave = max(enter, ends[0]), min(leave, ends[1])
        if enter <= leave:
            nearest = min(nearest, enter)
    return nearest


@settings(max_examples=60)
@given(GRIDS, st.integers(0, 2**32 - 1), st.booleans())
def test_rays_end_where_the_first_wall_is(grid: tuple[int, int, int, float], seed: int, is_aligned: bool) -> None:
    occupied = make_grid(*grid)
    height, width = occupied.shape
    random = np.random.default_rng(seed)
    x = ORIGIN[0] + random.uniform(0, width * RESOLUTION, 12)
    y = ORIGIN[1] + random.uniform(0, height * RESOLUTION, 12)
    angle = random.integers(-4, 5, 12) * np.pi / 4 if is_aligned else random.uniform(-7, 7, 12)
    ranges, _ = Walls(occupied, RESOLUTION, ORIGIN).cast(x, y, angle, 100.0)
    larger, smaller = boxes(occupied, SLACK), boxes(occupied, -SLACK)
    for found, *ray in zip(ranges, x, y, angle, strict=True):
        assert cast_slowly(larger, *ray) - SLACK <= found <= cast_slowly(smaller, *ray) + SLACK


def test_sides_and_range() -> None:
    """A room of 4 m x 3 m."""
    walls = Walls(np.zeros((6, 8), np.bool_), 0.5)
    angle = np.array([0, np.pi / 2, np.pi, -np.pi / 2, np.arctan2(2, 1)])
    x, y = np.full(5, 1.0), np.full(5, 1.0)
    ranges, faces_x = walls.cast(x, y, angle, 100.0)
    assert ranges == pytest.approx([3, 2, 1, 1, hypot(1, 2)])
    assert faces_x.tolist() == [True, False, True, False, False]
    assert walls.cast(x, y, angle, 1.5)[0] == pytest.approx([inf, inf, 1, 1, inf])
    assert walls.cast(x[:1], y[:1], angle[:1], 3.0)[0] == pytest.approx([3])


def test_rays_that_start_in_walls() -> None:
    walls = Walls(np.ones((2, 2), np.bool_), 1.0)
    x, y = np.array([0.5, -50.0, 1e9]), np.array([0.5, 0.5, -1e9])
    assert walls.cast(x, y, np.zeros(3), 10.0)[0].tolist() == [0, 0, 0]


@given(GRIDS)
def test_distances(grid: tuple[int, int, int, float]) -> None:
    occupied = np.pad(make_grid(*grid), 1, constant_values=True)
    cells = np.argwhere(occupied)
    expected = [
        [int(np.abs(cells - (row, column)).max(axis=1).min()) for column in range(occupied.shape[1])]
        for row in range(occupied.shape[0])
    ]
    assert chebyshev_distances(occupied).tolist() == expected


@settings(max_examples=60)
@given(GRIDS, st.integers(0, 2**32 - 1), st.floats(0.01, 1.0))
def test_discs_that_hit_walls(grid: tuple[int, int, int, float], seed: int, radius: float) -> None:
    occupied = make_grid(*grid)
    random = np.random.default_rng(seed)
    x = ORIGIN[0] + random.uniform(-0.5, occupied.shape[1] * RESOLUTION + 0.5, 12)
    y = ORIGIN[1] + random.uniform(-0.5, occupied.shape[0] * RESOLUTION + 0.5, 12)
    hit = Walls(occupied, RESOLUTION, ORIGIN).are_hit(x, y, radius)
    sides = boxes(occupied, 0.0)
    for found, centre_x, centre_y in zip(hit, x, y, strict=True):
        gap = min(
            hypot(max(left - centre_x, centre_x - right, 0), max(low - centre_y, centre_y - high, 0))
            for left, right, low, high in sides
        )
        is_outside = not (
            ORIGIN[0] <= centre_x <= ORIGIN[0] + occupied.shape[1] * RESOLUTION
            and ORIGIN[1] <= centre_y <= ORIGIN[1] + occupied.shape[0] * RESOLUTION
        )
        assert found == (gap < radius or is_outside)


@given(GRIDS, st.floats(0.01, 0.6))
def test_free_places_are_free(grid: tuple[int, int, int, float], clearance: float) -> None:
    walls = Walls(make_grid(*grid), RESOLUTION, ORIGIN)
    x, y = walls.free_places(clearance).T
    assert not walls.are_hit(x, y, clearance).any()


def test_there_are_free_places() -> None:
    places = Walls(np.zeros((7, 9), np.bool_), 0.5, (10.0, 20.0)).free_places(0.4)
    assert places[0].tolist() == [11.25, 21.25] and len(places) == 15


@pytest.mark.parametrize("place", [(100.0, 2.0), (-100.0, 2.0), (2.0, 1e300), (2.0, -7.0)])
def test_everything_beyond_the_grid_is_wall(place: tuple[float, float]) -> None:
    x, y = place
    assert Walls(np.zeros((10, 10), np.bool_), 0.5).are_hit(np.array([x, 2.0]), np.array([y, 2.0]), 0.2).tolist() == [
        True,
        False,
    ]
