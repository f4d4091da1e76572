"""Converts between pixels and the cells of a nav_msgs/OccupancyGrid (no I/O).

Cells are 0 (free) to 100 (occupied), or -1 (unknown); the first row is the lowest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyros1.robot_nodes.map_server.description import Description

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
_FREE_PIXEL, _OCCUPIED_PIXEL, _UNKNOWN_PIXEL = 254, 0, 205
"""Brightness in saved maps."""


def to_cells(pixels: NDArray[np.uint8], description: Description) -> NDArray[np.int8]:
    """Return the cells of a map.

    As in the original, "trinary" averages all channels, including alpha; the other modes leave alpha out. In "scale",
    pixels that are not opaque are unknown.

    Args:
        pixels: brightness with shape (height, width), or colours (RGB or RGBA) with shape (height, width, 3 or 4); the
            upper row first.
        description: defines how to interpret the pixels.

    Returns:
        An array of shape (height, width), the lower row first. In "raw", cells are pixels, modulo 256.
    """
    pixels = pixels[::-1]
    alpha = pixels[:, :, 3] if pixels.ndim == 3 and pixels.shape[2] == 4 else None
    # The sum of a pixel's channels has few possible values, so cells are looked up in a small table.
    if pixels.ndim == 2:
        sums, num_channels = pixels.astype(np.uint16), 1
    else:
        num_channels = pixels.shape[2] if description.mode == "trinary" else 3
        sums = pixels[:, :, :num_channels].sum(axis=2, dtype=np.uint16)
    cells: NDArray[np.int8] = _cells_of(np.arange(255 * num_channels + 1) / num_channels, description)[sums]
    if description.mode == "scale" and alpha is not None:
        cells[alpha < 255] = UNKNOWN
    return cells


def _cells_of(brightness: NDArray[np.float64], description: Description) -> NDArray[np.int8]:
    if description.negate:
        brightness = 255 - brightness
    if description.mode == "raw":
        return brightness.astype(np.uint8).view(np.int8)
    occupancy = (255 - brightness) / 255
    low, high = description.free_thresh, description.occupied_thresh
    if description.mode == "scale" and high > low:
        with np.errstate(over="ignore"):  # if the thresholds hardly differ; the result is clipped
            between = 1 + 98 * np.clip((occupancy - low) / (high - low), 0, 1)
    else:
        between = np.full(occupancy.shape, UNKNOWN)
    return np.where(occupancy > high, OCCUPIED, np.where(occupancy < low, FREE, between)).astype(np.int8)


def to_pixels(cells: NDArray[np.int8], free: int, occupied: int) -> NDArray[np.uint8]:
    """Return the image of a map, the upper row first.

    Args:
        cells: the map, with shape (height, width), the lower row first.
        free: the highest value of free cells.
        occupied: the lowest value of occupied cells.
    """
    cells = cells[::-1]
    unless_free = np.where(cells >= occupied, _OCCUPIED_PIXEL, _UNKNOWN_PIXEL)
    return np.where((cells >= 0) & (cells <= free), _FREE_PIXEL, unless_free).astype(np.uint8)
