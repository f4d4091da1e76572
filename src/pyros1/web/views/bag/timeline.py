"""Where a bag has messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.bag.file import BagView, topics
from pyros1.web.views.view import number

_MOST_ROWS = 200
_MOST_COLUMNS = 4_000
_LONGEST = 4.29e9  # two of them, in nanoseconds, have 64 bits


class BagTimelineView(BagView):
    """The rows of a timeline.

    Args (of the page):
        path: an open bag.
        begin, end: times of the edges, in seconds since the bag's beginning.
        columns: number of columns.
        topics: the rows.

    Pushes ``{"begin", "end", "columns", "topics", "exact"}`` with a float32 for each column of each row: how many
    messages are there, to one column. Without exact, some are further away.
    """

    def change(self, args: Mapping[str, Any]) -> None:
        begin = number(args, "begin", -_LONGEST, _LONGEST, 0.0)
        end = number(args, "end", -_LONGEST, _LONGEST, self.bag.length)
        if not begin < end:
            raise RequestError("a timeline ends after it begins")
        columns = int(number(args, "columns", 1, _MOST_COLUMNS, 600))
        self._wanted: tuple[float, float, int, list[str]] | None = (begin, end, columns, topics(args, _MOST_ROWS))

    def take(self) -> Push | None:
        wanted, self._wanted = self._wanted, None
        if wanted is None:
            return None
        begin, end, columns, names = wanted
        rows = self.bag.names(names)
        counts, exact = self.bag.look(begin, end, columns, rows)
        data = {"begin": begin, "end": end, "columns": columns, "topics": rows, "exact": exact}
        return Push(data, counts.tobytes())
