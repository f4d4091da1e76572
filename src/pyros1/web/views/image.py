"""Shows the newest image on a topic with sensor_msgs/Image or sensor_msgs/CompressedImage messages."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.transforms.image_size import MAX_PIXELS, image_size
from pyros1.web.transforms.rates import Meter
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MAX_IMAGE_SIZE = 64 << 20
"""Maximum size in bytes of an image sent to a page."""
COMPRESSED_TYPE = "sensor_msgs/CompressedImage"
_DEPTH_HEADER_SIZE = 12
"""Number of bytes before the PNG file in a message from compressed_depth_image_transport."""


def check_image(arrival: Arrival) -> str:
    """Check that a message is an image and not too large, and return the message's type.

    Raises:
        RequestError: the message is not an image, or is too large.
    """
    type_name: str = (arrival.raw._connection_header or {}).get("type", "")
    if type_name not in ("sensor_msgs/Image", COMPRESSED_TYPE):
        raise RequestError(f"this is not an image topic, its type is {type_name}")
    if len(arrival.raw._buff) > MAX_IMAGE_SIZE:
        raise RequestError(
            f"an image of {len(arrival.raw._buff) >> 20} MB is too large; the limit is {MAX_IMAGE_SIZE >> 20} MB"
        )
    return type_name


def page_image(arrival: Arrival) -> tuple[dict[str, Any], bytes]:
    """Return an image in the form that the page's panels draw.

    Returns:
        ``{"type", "encoding" or "format", "width", "height", "step", "bigendian", "frame", "stamp"}``, and the
        message's data.

    Raises:
        RequestError: see `check_image`; or the image would decode to more than fits in a page's memory.
        MessageError: see `Arrival.checked_message`.
    """
    type_name = check_image(arrival)
    message: Any = arrival.checked_message
    data = bytes(message.data)
    description = {"type": type_name, "frame": message.header.frame_id, "stamp": message.header.stamp.to_sec()}
    if type_name == COMPRESSED_TYPE:
        description["format"] = message.format
        width, height = image_size(data) or image_size(data[_DEPTH_HEADER_SIZE:]) or (0, 0)
        if width * height > MAX_PIXELS:
            raise RequestError(f"an image of {width} x {height} pixels is too large to display")
    else:
        description |= {
            "encoding": message.encoding,
            "width": message.width,
            "height": message.height,
            "step": message.step,
            "bigendian": bool(message.is_bigendian),
        }
    return description, data


class ImageView(View):
    """The images on a topic, which the page converts to colours.

    Args (sent by the page):
        topic: the topic's full name.

    Pushes the result of `page_image`, with "count" (images received so far) and "hz".
    """

    period = 1 / 30

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._lock = threading.Lock()
        self._newest: Arrival | None = None
        self._last_pushed: Arrival | None = None
        self._count = 0
        self._meter = Meter(monotonic())
        self._unsubscribe = robot.listen(string_arg(args, "topic"), self._on_message)

    def poll(self) -> Push | None:
        with self._lock:
            arrival, count = self._newest, self._count
        if arrival is None or arrival is self._last_pushed:
            return None
        self._last_pushed = arrival
        description, data = page_image(arrival)
        rate = self._meter.rate(monotonic())
        return Push({**description, "count": count, "hz": rate and rate.hz}, data)

    def close(self) -> None:
        self._unsubscribe()

    def _on_message(self, arrival: Arrival) -> None:
        with self._lock:
            self._newest = arrival
            self._count += 1
        self._meter.add(arrival.arrived_at, 0)
        self.wake()
