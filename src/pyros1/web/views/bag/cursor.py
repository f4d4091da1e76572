"""Shows a bag's messages at a point in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import untrusted
from pyros1.web.server.wire import Push
from pyros1.web.views.bag.file import BagView, topics_arg
from pyros1.web.views.message import tree
from pyros1.web.views.view import number_arg

_MAX_TOPICS = 8
_MAX_SECONDS = 4.29e9  # the sum of two such times in nanoseconds fits in 64 bits


class BagCursorView(BagView):
    """The last message on each topic at or before a time, as if all topics were latched.

    Args (sent by the page):
        path: path of an open bag.
        time: the time in seconds since the bag's start.
        topics: the names of the topics.

    Pushes ``{"time", "messages": {TOPIC: {"time", "type", "publisher", "value", "problem"}}}``; the value is a tree,
    see `MessageView`. Topics without a message until then are omitted.
    """

    def change(self, args: Mapping[str, Any]) -> None:
        time = number_arg(args, "time", -_MAX_SECONDS, _MAX_SECONDS, 0.0)
        self._request: tuple[float, list[str]] | None = (time, self.bag.recorded_names(topics_arg(args, _MAX_TOPICS)))

    def poll(self) -> Push | None:
        request, self._request = self._request, None
        if request is None:
            return None
        time, names = request
        messages = {}
        for name in names:  # one by one, so that a topic whose messages cannot be read does not affect the others
            try:
                for topic, item in self.bag.messages_at(time, [name]).items():
                    messages[topic] = {
                        "time": self.bag.seconds(item.time.to_nsec()),
                        "type": untrusted(item.connection.type),
                        "publisher": untrusted(item.connection.callerid),
                        "value": tree(item.message),
                        "problem": "",
                    }
            except Error as error:
                messages[name] = {
                    "time": None,
                    "type": "",
                    "publisher": "",
                    "value": None,
                    "problem": untrusted(str(error)),
                }
        return Push({"time": time, "messages": messages})
