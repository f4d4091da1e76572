"""Small pictures of a bag's images."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import untrusted
from pyros1.web.bags.open_bag import IMAGES
from pyros1.web.bags.pictures import picture
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.bag.file import BagView
from pyros1.web.views.view import number, text

MAX_PICTURES = 64
"""Maximum number of pictures per request."""
MAX_HEIGHT = 720
_MAX_SECONDS = 4.29e9  # the sum of two of them, in nanoseconds, fits into 64 bits


class BagPicturesView(BagView):
    """Images of a topic at several times, one after the other.

    Args (of the page):
        path: an open bag.
        topic: a topic with images.
        times: in seconds since the bag's beginning; for each, the last image at or before it is displayed.
        height: maximum height of the pictures in pixels; smaller ones are not scaled.

    Pushes ``{"topic", "wanted", "time", "width", "height", "problem"}`` with the picture as JPEG; it is empty if there
    is a problem, or no image yet.
    """

    polled = True

    def change(self, args: Mapping[str, Any]) -> None:
        name = text(args, "topic")
        known = self.bag.topic(name)
        if known is None or known.type not in IMAGES:
            raise RequestError(f"{untrusted(name[:200])} has no images")
        times = args.get("times", [])
        if not isinstance(times, list) or len(times) > MAX_PICTURES:
            raise RequestError(f"times is a list of at most {MAX_PICTURES}")
        self._topic = known.name
        self._height = int(number(args, "height", 8, MAX_HEIGHT, 60))
        self._request = deque(number({"time": each}, "time", -_MAX_SECONDS, _MAX_SECONDS, 0.0) for each in times)
        self.polled = True

    def poll(self) -> Push | None:
        if not self._request:
            self.polled = False  # until the next change
            return None
        request = self._request.popleft()
        facts = {"topic": self._topic, "wanted": request, "time": None, "width": 0, "height": 0, "problem": ""}
        try:
            for item in self.bag.at(request, [self._topic]).values():
                data, width, height = picture(item.message, self._height)
                time = self.bag.seconds(item.time.to_nsec())
                return Push({**facts, "time": time, "width": width, "height": height}, data)
        except Error as error:
            return Push({**facts, "problem": untrusted(str(error))}, b"")
        return Push(facts, b"")
