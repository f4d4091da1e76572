"""Occupancy grids, and updates of parts of them (map_msgs/OccupancyGridUpdate) (pure)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.web.scene.shape import Shape, ShapeError
from pyros1.web.scene.shapes import occupancy_grid

UPDATES = "_updates"
"""Suffix that is appended to a grid's topic to get the topic of its updates."""


class Grid:
    """A grid, with the part of it that has not been sent yet."""

    def __init__(self) -> None:
        self._description: dict[str, Any] = {}
        self._cells: NDArray[np.int8] | None = None
        self._changed_area: tuple[int, int, int, int] | None = None  # left, bottom, right, top
        self._send_all = True
        self.message: Any = None

    def put(self, message: Any) -> None:
        """Process a nav_msgs/OccupancyGrid.

        Raises:
            ShapeError: the grid cannot be drawn.
        """
        self._cells = None
        description, cells = occupancy_grid(message)
        self._description, self.message = description, message
        self._cells = np.frombuffer(cells, np.int8).reshape(description["height"], description["width"]).copy()
        self.resend()

    def update(self, message: Any) -> None:
        """Process a map_msgs/OccupancyGridUpdate; it is ignored if there is no grid.

        Raises:
            ShapeError: the update does not fit into the grid.
        """
        if self._cells is None:
            return
        height, width = self._cells.shape
        left, low, right, high = message.x, message.y, message.x + message.width, message.y + message.height
        if min(left, low) < 0 or right > width or high > height:
            raise ShapeError(
                f"an update of {message.width} x {message.height} cells at ({left}, {low}) exceeds the map"
            )
        if len(message.data) != message.width * message.height:
            raise ShapeError(f"an update of {message.width} x {message.height} cells has {len(message.data)} values")
        self._cells[low:high, left:right] = np.asarray(message.data, np.int8).reshape(message.height, message.width)
        if self._changed_area is not None:
            previous = self._changed_area
            left, low, right, high = (
                min(left, previous[0]),
                min(low, previous[1]),
                max(right, previous[2]),
                max(high, previous[3]),
            )
        self._changed_area = (left, low, right, high)

    def resend(self) -> None:
        """Let `take` return the whole grid next time."""
        self._send_all, self._changed_area = True, None

    def take(self) -> Shape | None:
        """Return the grid if it is new, else the changed part with its "x" and "y" in cells; None if unchanged."""
        if self._cells is None:
            return None
        changed, send_all = self._changed_area, self._send_all
        self._changed_area, self._send_all = None, False
        if send_all:
            return {**self._description}, self._cells.tobytes()
        if changed is None:
            return None
        left, low, right, high = changed
        description = {"kind": "patch", "x": left, "y": low, "width": right - left, "height": high - low}
        return description, self._cells[low:high, left:right].tobytes()
