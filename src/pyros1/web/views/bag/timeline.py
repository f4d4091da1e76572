"""Shows how a bag's messages are distributed over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.bag.file import BagView, topics_arg
from pyros1.web.views.view import number_arg

_MAX_ROWS = 200
_MAX_COLUMNS = 4_000
_MAX_SECONDS = 4.29e9  # the sum of two such times in nanoseconds fits in 64 bits


class BagTimelineView(BagView):
    """The rows of a timeline, one per topic.

    Args (sent by the page):
        path: path of an open bag.
        begin, end: the times at the left and right edge, in seconds since the bag's start.
        columns: number of columns.
        topics: the names of the rows' topics.

    Pushes ``{"begin", "end", "columns", "topics", "exact"}`` with the number of messages in each column of each row, as
    float32. If "exact" is true, each message is counted at most one column away from its own; otherwise, some messages
    may be counted further away.
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
