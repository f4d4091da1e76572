"""Keeps occupancy grids, and applies updates to parts of them (no I/O)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.web.scene.shape import Shape, ShapeError
from pyros1.web.scene.shapes import occupancy_grid

UPDATES_SUFFIX = "_updates"
"""Suffix that turns a grid's topic into the topic of its updates."""


class Grid:
    """A grid, which keeps track of the part that has changed since it was last sent to the page."""

    def __init__(self) -> None:
        self._description: dict[str, Any] = {}
        self._cells: NDArray[np.int8] | None = None
        self._changed_area: tuple[int, int, int, int] | None = None  # left, bottom, right, top
        self._send_all = True
        self.message: Any = None

    def put(self, message: Any) -> None:
        """Replace the grid by a nav_msgs/OccupancyGrid.

        Raises:
            ShapeError: the grid cannot be drawn.
        """
        self._cells = None
        description, cells = occupancy_grid(message)
        self._description, self.message = description, message
        self._cells = np.frombuffer(cells, np.int8).reshape(description["height"], description["width"]).copy()
        self.resend()

    def update(self, message: Any) -> None:
        """Apply a map_msgs/OccupancyGridUpdate; it is ignored if there is no grid.

        Raises:
            ShapeError: the update extends beyond the grid, or has the wrong number of cells.
        """
        if self._cells is None:
            return
        height, width = self._cells.shape
        left, bottom, right, top = message.x, message.y, message.x + message.width, message.y + message.height
        if min(left, bottom) < 0 or right > width or top > height:
            raise ShapeError(
                f"an update of {message.width} x {message.height} cells at ({left}, {bottom}) exceeds the map"
            )
        if len(message.data) != message.width * message.height:
            raise ShapeError(f"an update of {message.width} x {message.height} cells has {len(message.data)} values")
        self._cells[bottom:top, left:right] = np.asarray(message.data, np.int8).reshape(message.height, message.width)
        if self._changed_area is not None:
            previous = self._changed_area
            left, bottom, right, top = (
                min(left, previous[0]),
                min(bottom, previous[1]),
                max(right, previous[2]),
                max(top, previous[3]),
            )
        self._changed_area = (left, bottom, right, top)

    def resend(self) -> None:
        """Make the next call of `take` return the whole grid."""
        self._send_all, self._changed_area = True, None

    def take(self) -> Shape | None:
        """Return what the page needs next: the whole grid, or a "patch" with the changed part; None if it needs
        nothing.
        """
        if self._cells is None:
            return None
        changed, send_all = self._changed_area, self._send_all
        self._changed_area, self._send_all = None, False
        if send_all:
            return {**self._description}, self._cells.tobytes()
        if changed is None:
            return None
        left, bottom, right, top = changed
        description = {"kind": "patch", "x": left, "y": bottom, "width": right - left, "height": top - bottom}
        return description, self._cells[bottom:top, left:right].tobytes()
