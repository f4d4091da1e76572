"""Counts a bag's messages per column of a timeline, using the bag's index of chunks (no I/O).

The index contains each chunk's start, end, and number of messages per topic. That is enough for a chunk that covers one
or two columns: no message is displayed more than one column away from where it belongs. For a longer chunk, the exact
times of its messages are requested if there are few of them; otherwise, the messages are spread evenly.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

MAX_EXACT_MESSAGES = 500_000
"""Maximum number of messages whose exact times are requested per histogram."""
ReadTimes = Callable[[int], Iterable[tuple[int, "NDArray[np.int64]"]]]
"""Takes a chunk's number; returns each row's number and the times of the row's messages in nanoseconds."""


class Density:
    """The distribution of a bag's messages over time.

    Args:
        chunks: for each chunk, its first and last time in nanoseconds, and pairs of a row and the row's number of
            messages.
    """

    def __init__(self, chunks: Iterable[tuple[int, int, Iterable[tuple[int, int]]]]) -> None:
        chunk_numbers, rows, counts = array("q"), array("q"), array("q")
        starts, ends, totals = array("q"), array("q"), array("q")
        for number, (start, end, by_row) in enumerate(chunks):
            starts.append(start)
            ends.append(end)
            total = 0
            for row, count in by_row:
                chunk_numbers.append(number)
                rows.append(row)
                counts.append(count)
                total += count
            totals.append(total)
        self._chunks, self._rows, self._counts = (
            np.asarray(values, np.int64) for values in (chunk_numbers, rows, counts)
        )
        self._starts, self._ends, self._totals = (np.asarray(values, np.int64) for values in (starts, ends, totals))

    def histogram(
        self, begin: int, end: int, columns: int, rows: Sequence[int], read_times: ReadTimes, max_chunks: int = 200
    ) -> tuple[NDArray[np.float32], bool]:
        """Return the number of messages in each column.

        Args:
            begin: the time at the left edge of the timeline, in nanoseconds.
            end: the time at the right edge, later than `begin`.
            columns: number of columns.
            rows: the rows whose messages are counted.
            read_times: returns the exact times of a chunk's messages.
            max_chunks: maximum number of chunks for which `read_times` is called.

        Returns:
            An array of shape (rows, columns), and whether every message is counted at most one column away from where
            it belongs.
        """
        grid = np.zeros((len(rows), columns + 1), np.float64)
        # Row number -> index in `rows`, or -1. The last entry is for messages whose row number is -1, as they belong to
        # no row.
        grid_row = np.full(int(max(self._rows, default=0)) + 2, -1, np.int64)
        for index, row in enumerate(rows):
            if 0 <= row < len(grid_row) - 1:
                grid_row[row] = index
        column_width = (end - begin) / columns
        first = np.floor((self._starts - begin) / column_width).astype(np.int64)
        last = np.floor((self._ends - begin) / column_width).astype(np.int64)
        visible = (last >= 0) & (first < columns) & (self._totals > 0)
        wide_chunks = np.flatnonzero(visible & (last > first + 1))
        exact_chunks = self._select_exact_chunks(wide_chunks)[:max_chunks]
        entries = np.flatnonzero(visible[self._chunks] & (grid_row[self._rows] >= 0))
        entries = entries[~np.isin(self._chunks[entries], exact_chunks)]
        self._spread_evenly(grid, grid_row[self._rows[entries]], first, last, entries)
        totals = grid[:, :columns]
        for number in exact_chunks:
            for row, stamps in read_times(int(number)):
                if 0 <= row < len(grid_row) and grid_row[row] >= 0:
                    message_columns = ((stamps - begin) / column_width).astype(np.int64)[
                        (stamps >= begin) & (stamps < end)
                    ]
                    totals[grid_row[row]] += np.bincount(np.minimum(message_columns, columns - 1), minlength=columns)
        return totals.astype(np.float32), len(exact_chunks) == len(wide_chunks)

    def _select_exact_chunks(self, wide_chunks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the chunks whose exact times are requested: the smallest, up to `MAX_EXACT_MESSAGES` in total."""
        order = wide_chunks[np.argsort(self._totals[wide_chunks], kind="stable")]
        return order[np.cumsum(self._totals[order]) <= MAX_EXACT_MESSAGES]

    def _spread_evenly(
        self,
        grid: NDArray[np.float64],
        grid_rows: NDArray[np.int64],
        first: NDArray[np.int64],
        last: NDArray[np.int64],
        entries: NDArray[np.int64],
    ) -> None:
        """Add each entry's messages to the grid, spread evenly over the columns of the entry's chunk.

        For each entry, the number of messages per column is first added at the chunk's first column, and subtracted
        after its last column. The cumulative sums are then the numbers of messages in each column.
        """
        columns = grid.shape[1] - 1
        starts, ends = first[self._chunks[entries]], last[self._chunks[entries]]
        messages_per_column = self._counts[entries] / (ends - starts + 1)
        flat_grid = grid.reshape(-1)
        left, right = np.maximum(starts, 0), np.minimum(ends, columns - 1) + 1
        flat_grid += np.bincount(grid_rows * (columns + 1) + left, messages_per_column, flat_grid.size)
        flat_grid -= np.bincount(grid_rows * (columns + 1) + right, messages_per_column, flat_grid.size)
        np.cumsum(grid, axis=1, out=grid)
        np.round(grid, 6, out=grid)
        np.maximum(grid, 0, out=grid)
