"""The number of a bag's messages over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.bag.file import BagView, topics_arg
from pyros1.web.views.view import number_arg

_MAX_ROWS = 200
_MAX_COLUMNS = 4_000
_MAX_SECONDS = 4.29e9  # the sum of two such times in nanoseconds fits into 64 bits


class BagTimelineView(BagView):
    """The rows of a timeline, one per topic.

    Args (of the page):
        path: path of an open bag.
        begin, end: the times of both edges, in seconds since the bag's start.
        columns: number of columns.
        topics: the topics of the rows.

    Pushes ``{"begin", "end", "columns", "topics", "exact"}`` with a float32 for each column of each row: the number
    of messages. If "exact", each message is counted at most one column away from its own; otherwise, some may be
    further away.
    """

    def change(self, args: Mapping[str, Any]) -> None:
        begin = number_arg(args, "begin", -_MAX_SECONDS, _MAX_SECONDS, 0.0)
        end = number_arg(args, "end", -_MAX_SECONDS, _MAX_SECONDS, self.bag.length)
        if not begin < end:
            raise RequestError("a timeline must end after it begins")
        columns = int(number_arg(args, "columns", 1, _MAX_COLUMNS, 600))
        self._request: tuple[float, float, int, list[str]] | None = (begin, end, columns, topics_arg(args, _MAX_ROWS))

    def poll(self) -> Push | None:
        request, self._request = self._request, None
        if request is None:
            return None
        begin, end, columns, names = request
        recorded_names = self.bag.recorded_names(names)
        counts, exact = self.bag.histogram(begin, end, columns, recorded_names)
        data = {"begin": begin, "end": end, "columns": columns, "topics": recorded_names, "exact": exact}
        return Push(data, counts.tobytes())
