"""Shows thumbnails of a bag's images."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import untrusted
from pyros1.web.bags.open_bag import IMAGE_TYPES
from pyros1.web.bags.thumbnails import thumbnail
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.bag.file import BagView
from pyros1.web.views.view import number_arg, string_arg

MAX_THUMBNAILS = 64
"""Maximum number of thumbnails per request."""
MAX_HEIGHT = 720
_MAX_SECONDS = 4.29e9  # the sum of two such times in nanoseconds fits in 64 bits


class BagPicturesView(BagView):
    """Thumbnails of the images on a topic at several times, pushed one by one.

    Args (sent by the page):
        path: path of an open bag.
        topic: name of a topic with images.
        times: times in seconds since the bag's start; for each, the last image at or before this time is displayed.
        height: maximum height of the thumbnails in pixels; smaller images are not scaled.

    Pushes ``{"topic", "wanted", "time", "width", "height", "problem"}`` with the thumbnail as a JPEG file, which is
    empty if there is a problem, or no image at or before the time.
    """

    polls_periodically = True

    def change(self, args: Mapping[str, Any]) -> None:
        name = string_arg(args, "topic")
        bag_topic = self.bag.topic(name)
        if bag_topic is None or bag_topic.type not in IMAGE_TYPES:
            raise RequestError(f"{untrusted(name[:200])} has no images")
        times = args.get("times", [])
        if not isinstance(times, list) or len(times) > MAX_THUMBNAILS:
            raise RequestError(f"times must be a list of at most {MAX_THUMBNAILS} numbers")
        self._topic = bag_topic.name
        self._height = int(number_arg(args, "height", 8, MAX_HEIGHT, 60))
        self._pending_times = deque(
            number_arg({"time": time}, "time", -_MAX_SECONDS, _MAX_SECONDS, 0.0) for time in times
        )
        self.polls_periodically = True

    def poll(self) -> Push | None:
        if not self._pending_times:
            self.polls_periodically = False  # until the next change
            return None
        requested_time = self._pending_times.popleft()
        description = {
            "topic": self._topic,
            "wanted": requested_time,
            "time": None,
            "width": 0,
            "height": 0,
            "problem": "",
        }
        try:
            for item in self.bag.messages_at(requested_time, [self._topic]).values():
                data, width, height = thumbnail(item.message, self._height)
                time = self.bag.seconds(item.time.to_nsec())
                return Push({**description, "time": time, "width": width, "height": height}, data)
        except Error as error:
            return Push({**description, "problem": untrusted(str(error))}, b"")
        return Push(description, b"")
