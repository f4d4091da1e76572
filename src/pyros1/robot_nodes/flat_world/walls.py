"""The walls of a flat world: where they stop rays, and where robots hit them (no I/O)."""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
_STRAIGHT = 1e-12
"""Minimum component of a direction along an axis, which prevents division by 0."""


class Walls:
    """Walls, which are the occupied cells of a grid. Everything beyond the grid is wall.

    Args:
        occupied: whether each cell is wall; shape (height, width), the row with the lowest y first.
        resolution: size of a cell in m.
        origin: x and y of the grid's lower left corner in m.
    """

    def __init__(self, occupied: Flags, resolution: float, origin: tuple[float, float] = (0.0, 0.0)) -> None:
        self.occupied = occupied
        self.resolution = resolution
        # A border of wall keeps all indices in range.
        self._origin_x, self._origin_y = (value - resolution for value in origin)
        self._distances = chebyshev_distances(np.pad(occupied, 1, constant_values=True))

    def cast(self, x: Floats, y: Floats, angle: Floats, max_range: float) -> tuple[Floats, Flags]:
        """Cast rays.

        Each step jumps to the edge of the largest square of free cells around a ray's cell, so a ray needs few steps,
        and finds the same cell as if it went from cell to cell.

        Args:
            x, y: where the rays start, in m; shape (n,).
            angle: their directions in radians; shape (n,).
            max_range: their maximum length in m.

        Returns:
            The distances to the walls in m, infinite if there is none within `max_range`; and whether each wall was hit
            on a side that faces along x. Both have shape (n,).
        """
        ranges, faces_x = np.full(x.shape, np.inf), np.zeros(x.shape, np.bool_)
        start = np.stack(self._to_cells(x, y))
        heading = np.stack([np.cos(angle), np.sin(angle)])
        heading[np.abs(heading) < _STRAIGHT] = _STRAIGHT
        inverse, forward = 1 / heading, heading > 0
        cell = self._clip(np.floor(start).astype(np.int64))
        way = np.zeros(x.shape)  # how far the rays have gone, in cells
        along_x = np.zeros(x.shape, np.bool_)
        rays = np.arange(x.size)
        limit = max_range / self.resolution
        while rays.size:
            distance = self._distances[cell[1], cell[0]]
            hit = (distance == 0) & (way <= limit)
            ranges[rays[hit]] = way[hit] * self.resolution
            faces_x[rays[hit]] = along_x[hit]
            going = np.flatnonzero((distance != 0) & (way <= limit))
            rays, distance = rays[going], distance[going]
            start, heading, inverse = start[:, going], heading[:, going], inverse[:, going]
            forward, cell = forward[:, going], cell[:, going]
            # The square reaches from cell - distance + 1 to cell + distance - 1; its edges are at whole numbers.
            to_edges = (cell + np.where(forward, distance, 1 - distance) - start) * inverse
            along_x = to_edges[0] < to_edges[1]
            way = np.where(along_x, to_edges[0], to_edges[1])
            inside = np.floor(start + way * heading).astype(np.int64)
            inside = np.minimum(np.maximum(inside, cell - distance + 1), cell + distance - 1)
            beyond = cell + np.where(forward, distance, -distance)
            cell = np.where(np.stack([along_x, ~along_x]), beyond, inside)
        return ranges, faces_x

    def are_hit(self, x: Floats, y: Floats, radius: float) -> Flags:
        """Return whether discs overlap walls.

        Args:
            x, y: their centres in m; shape (n,).
            radius: their radius in m.
        """
        centre_x, centre_y = self._to_cells(x, y)
        centres = np.floor(np.stack([centre_x, centre_y]))
        cells = self._clip(centres).astype(np.int64)
        reach = ceil(radius / self.resolution)
        hit: Flags = (cells != centres).any(axis=0)  # beyond the grid
        # All others are beyond the grid, or too far from any wall.
        near = np.flatnonzero(~hit & (self._distances[cells[1], cells[0]] <= reach))
        if near.size:
            offsets = np.arange(-reach, reach + 1)
            columns = cells[0, near, None, None] + offsets[None, None, :]
            rows = cells[1, near, None, None] + offsets[None, :, None]
            # The distances from the disc's centre to the nearest point of each cell.
            gap_x = _gap(centre_x[near, None, None], columns)
            gap_y = _gap(centre_y[near, None, None], rows)
            columns, rows = self._clip(np.stack(np.broadcast_arrays(columns, rows)))
            walls = self._distances[rows, columns] == 0
            overlap = gap_x**2 + gap_y**2 < (radius / self.resolution) ** 2
            hit[near] = (walls & overlap).any(axis=(1, 2))
        return hit

    def free_places(self, clearance: float) -> Floats:
        """Return the centres of cells that are at least this far from all walls, in m, with shape (n, 2)."""
        cells = np.argwhere(self._distances > ceil(clearance / self.resolution) + 1)[:, ::-1]
        places: Floats = (cells + 0.5) * self.resolution + np.array([self._origin_x, self._origin_y])
        return places

    def _to_cells(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        return (x - self._origin_x) / self.resolution, (y - self._origin_y) / self.resolution

    def _clip(self, cells: Any) -> Any:
        """Move cells beyond the border onto it; shape (2, ...), columns first."""
        height, width = self._distances.shape
        return np.stack([np.clip(cells[0], 0, width - 1), np.clip(cells[1], 0, height - 1)])


def _gap(centre: Floats, cells: Ints) -> Floats:
    gap: Floats = np.maximum(0, np.maximum(cells - centre, centre - cells - 1))
    return gap


def chebyshev_distances(occupied: Flags) -> Ints:
    """Return each cell's distance from the nearest occupied cell, in steps along x, y or the diagonals.

    Args:
        occupied: which cells are occupied, at least one; shape (height, width).
    """
    height, width = occupied.shape
    columns = np.arange(width)
    distances = np.where(occupied, 0, height + width).astype(np.int64)
    # Down, then up. Distances spread from the previous row, plus one, and within a row by running minima.
    for rows in (distances, distances[::-1]):
        for number, row in enumerate(rows):
            if number:
                before = np.pad(rows[number - 1] + 1, 1, constant_values=height + width)
                np.minimum(row, np.minimum(np.minimum(before[:-2], before[1:-1]), before[2:]), out=row)
            np.minimum(row, np.minimum.accumulate(row - columns) + columns, out=row)
            np.minimum(row, (np.minimum.accumulate(row[::-1] - columns) + columns)[::-1], out=row)
    return distances
