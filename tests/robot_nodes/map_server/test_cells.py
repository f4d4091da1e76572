from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.map_server.cells import to_cells, to_pixels
from pyros1.robot_nodes.map_server.description import MODES, Description


def cell_of(pixel: list[int], description: Description) -> int:
    """Return what the wiki page says of a pixel."""
    has_alpha = len(pixel) == 4
    counted = pixel if description.mode == "trinary" else pixel[:3]
    brightness = sum(counted) / len(counted)
    if description.negate:
        brightness = 255 - brightness
    if description.mode == "raw":
        value = int(brightness)
        return value - 256 if value > 127 else value
    if description.mode == "scale" and has_alpha and pixel[3] < 255:
        return -1
    occupancy = (255 - brightness) / 255
    if occupancy > description.occupied_thresh:
        return 100
    if occupancy < description.free_thresh:
        return 0
    if description.mode == "trinary" or description.occupied_thresh <= description.free_thresh:
        return -1
    share = (occupancy - description.free_thresh) / (description.occupied_thresh - description.free_thresh)
    return int(1 + 98 * share)


DESCRIPTIONS = st.builds(
    Description,
    st.just("a"),
    st.just(0.05),
    negate=st.booleans(),
    occupied_thresh=st.floats(-0.5, 1.5),
    free_thresh=st.floats(-0.5, 1.5),
    mode=st.sampled_from(MODES),
)


@given(DESCRIPTIONS, st.sampled_from([(), (3,), (4,)]), st.integers(0, 2**32 - 1))
def test_every_pixel(description: Description, channels: Any, seed: int) -> None:
    random = np.random.default_rng(seed)
    pixels = random.integers(0, 256, (4, 5, *channels)).astype(np.uint8)
    if channels == (4,):
        pixels[:2, :, 3] = 255
    expected = [[cell_of(np.atleast_1d(pixel).tolist(), description) for pixel in row] for row in pixels[::-1]]
    cells = to_cells(pixels, description)
    assert (cells.tolist(), cells.dtype) == (expected, np.int8)


def test_thresholds_of_stock() -> None:
    row = np.array([[0, 89, 90, 205, 206, 254, 255]], np.uint8)
    assert to_cells(row, Description("a", 0.05)).tolist() == [[100, 100, -1, -1, 0, 0, 0]]
    assert to_cells(row, Description("a", 0.05, negate=True)).tolist() == [[0, -1, -1, 100, 100, 100, 100]]
    scaled = to_cells(row, Description("a", 0.05, mode="scale")).tolist()
    assert scaled == [[100, 100, 98, 1, 0, 0, 0]]


def test_saved_cells_are_the_same() -> None:
    cells = np.array([[0, 100], [-1, 0], [100, -1]], np.int8)
    again = to_cells(to_pixels(cells, 25, 65), Description("a", 0.05))
    assert np.array_equal(again, cells)


def test_thresholds_of_map_saver() -> None:
    cells = np.array([[-128, -1, 0, 25, 26, 64, 65, 100, 127]], np.int8)
    assert to_pixels(cells, 25, 65).tolist() == [[205, 205, 254, 254, 205, 205, 0, 0, 0]]
