"""Where a bag has messages: counts per column of a timeline, from the index of its chunks. Pure.

The index gives the start and end of each chunk, and its number of messages per topic. That is good enough if a chunk
lies in one or two columns: no message is displayed more than a column away. For longer chunks, the times of their
messages are requested if they are few; otherwise the messages are spread evenly.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

MAX_EXACT = 500_000
"""Maximum number of messages whose exact times are requested per call."""
Times = Callable[[int], Iterable[tuple[int, "NDArray[np.int64]"]]]
"""Returns pairs of a row and the times of its messages in nanoseconds, for the number of a chunk."""


class Density:
    """The index of a bag.

    Args:
        chunks: for each chunk its first and last time in nanoseconds, and the number of messages by row.
    """

    def __init__(self, chunks: Iterable[tuple[int, int, Iterable[tuple[int, int]]]]) -> None:
        numbers, rows, counts = array("q"), array("q"), array("q")
        starts, ends, totals = array("q"), array("q"), array("q")
        for number, (start, end, by_row) in enumerate(chunks):
            starts.append(start)
            ends.append(end)
            total = 0
            for row, count in by_row:
                numbers.append(number)
                rows.append(row)
                counts.append(count)
                total += count
            totals.append(total)
        self._chunk, self._row, self._count = (np.asarray(each, np.int64) for each in (numbers, rows, counts))
        self._starts, self._ends, self._totals = (np.asarray(each, np.int64) for each in (starts, ends, totals))

    def histogram(
        self, begin: int, end: int, columns: int, rows: Sequence[int], times: Times, max_chunks: int = 200
    ) -> tuple[NDArray[np.float32], bool]:
        """Return how many messages are in each column.

        Args:
            begin: time at the left edge, in nanoseconds.
            end: time at the right edge, later than `begin`.
            columns: number of columns.
            rows: the rows to count.
            times: called for the times of single messages.
            max_chunks: maximum number of chunks for which it is called.

        Returns:
            An array of shape (rows, columns), and whether all messages are at most one column off.
        """
        grid = np.zeros((len(rows), columns + 1), np.float64)
        grid_row = np.full(int(max(self._row, default=0)) + 2, -1, np.int64)  # the last one is for the row -1: none
        for index, row in enumerate(rows):
            if 0 <= row < len(grid_row) - 1:
                grid_row[row] = index
        size = (end - begin) / columns
        first = np.floor((self._starts - begin) / size).astype(np.int64)
        last = np.floor((self._ends - begin) / size).astype(np.int64)
        visible = (last >= 0) & (first < columns) & (self._totals > 0)
        wide_chunks = np.flatnonzero(visible & (last > first + 1))
        exact = self._small_enough(wide_chunks)[:max_chunks]
        entries = np.flatnonzero(visible[self._chunk] & (grid_row[self._row] >= 0))
        entries = entries[~np.isin(self._chunk[entries], exact)]
        self._spread_evenly(grid, grid_row[self._row[entries]], first, last, entries)
        counted = grid[:, :columns]
        for number in exact:
            for row, stamps in times(int(number)):
                if 0 <= row < len(grid_row) and grid_row[row] >= 0:
                    columns_hit = ((stamps - begin) / size).astype(np.int64)[(stamps >= begin) & (stamps < end)]
                    counted[grid_row[row]] += np.bincount(np.minimum(columns_hit, columns - 1), minlength=columns)
        return counted.astype(np.float32), len(exact) == len(wide_chunks)

    def _small_enough(self, wide_chunks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the chunks whose times are requested: the small ones, as many as the limit allows."""
        order = wide_chunks[np.argsort(self._totals[wide_chunks], kind="stable")]
        return order[np.cumsum(self._totals[order]) <= MAX_EXACT]

    def _spread_evenly(
        self,
        grid: NDArray[np.float64],
        grid_rows: NDArray[np.int64],
        first: NDArray[np.int64],
        last: NDArray[np.int64],
        entries: NDArray[np.int64],
    ) -> None:
        """Add each entry's messages, in equal shares to its columns: what begins there, minus what ends."""
        columns = grid.shape[1] - 1
        from_, to = first[self._chunk[entries]], last[self._chunk[entries]]
        share = self._count[entries] / (to - from_ + 1)
        flat = grid.reshape(-1)
        left, right = np.maximum(from_, 0), np.minimum(to, columns - 1) + 1
        flat += np.bincount(grid_rows * (columns + 1) + left, share, flat.size)
        flat -= np.bincount(grid_rows * (columns + 1) + right, share, flat.size)
        np.cumsum(grid, axis=1, out=grid)
        np.round(grid, 6, out=grid)
        np.maximum(grid, 0, out=grid)
