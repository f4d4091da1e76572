"""Counts a bag's messages per column of a timeline, from the index of its chunks (pure).

The index contains the start and end of each chunk, and its number of messages per topic. That is good enough if a chunk
covers one or two columns: no message is displayed more than one column away. For longer chunks, the exact times of
their messages are requested if there are few; otherwise the messages are spread evenly.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

MAX_EXACT = 500_000
"""Maximum number of messages whose exact times are requested per histogram."""
ReadTimes = Callable[[int], Iterable[tuple[int, "NDArray[np.int64]"]]]
"""Takes a chunk's number; returns, for each row, its number and the times of its messages in nanoseconds."""


class Density:
    """The distribution of a bag's messages over time.

    Args:
        chunks: the first and last time of each chunk in nanoseconds, and its numbers of messages, as pairs of row and
        number.
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
            begin: the time at the left edge, in nanoseconds.
            end: the time at the right edge, later than `begin`.
            columns: number of columns.
            rows: the rows to count.
            read_times: returns the exact times of a chunk's messages.
            max_chunks: maximum number of chunks for which `read_times` is called.

        Returns:
            An array of shape (rows, columns), and whether all messages are counted at most one column away from their
            own.
        """
        grid = np.zeros((len(rows), columns + 1), np.float64)
        grid_row = np.full(int(max(self._rows, default=0)) + 2, -1, np.int64)  # the last entry is for row -1: no row
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
        """Return the chunks whose exact times are requested: the smallest ones, as many as `MAX_EXACT` allows."""
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
        """Spread each entry's messages evenly over its columns: add them in its first, subtract them after its last."""
        columns = grid.shape[1] - 1
        starts, ends = first[self._chunks[entries]], last[self._chunks[entries]]
        per_column = self._counts[entries] / (ends - starts + 1)
        flat = grid.reshape(-1)
        left, right = np.maximum(starts, 0), np.minimum(ends, columns - 1) + 1
        flat += np.bincount(grid_rows * (columns + 1) + left, per_column, flat.size)
        flat -= np.bincount(grid_rows * (columns + 1) + right, per_column, flat.size)
        np.cumsum(grid, axis=1, out=grid)
        np.round(grid, 6, out=grid)
        np.maximum(grid, 0, out=grid)
