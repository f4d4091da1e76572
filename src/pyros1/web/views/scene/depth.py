"""A camera's depths as a point cloud."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.web.hub import Arrival
from pyros1.web.scene.camera import Camera
from pyros1.web.scene.clouds import MAX_POINTS
from pyros1.web.scene.depth import colours, depth_cloud, depths
from pyros1.web.scene.shape import ShapeError
from pyros1.web.server.wire import RequestError
from pyros1.web.views.image import check_picture
from pyros1.web.views.scene.camera import CameraView
from pyros1.web.views.view import number, text

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_PICTURES = 4
"""Number of recent colour pictures from which the one taken together with the depths is chosen."""
KEPT_BYTES = 32 << 20
"""Maximum bytes of these; but one is always kept."""


class SceneDepthView(CameraView):
    """Depths as a cloud, with the colours of another picture.

    Args (of the page):
        topic, info, fixed: see `CameraView`; the topic has depth images.
        colour: the full name of a topic with pictures from the same viewpoint; empty for none.
        most: approximate maximum number of points that are sent.
        numbers: whether to send their indices in the picture as well.

    Pushes the result of `pyros1.web.scene.depth.depth_cloud`, with "frame", "stamp" and "pose".
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self._pictures: deque[Arrival] = deque()
        self._colour = ""
        super().__init__(robot, args, wake)
        try:
            self._read(args)
        except BaseException:
            self.close()
            raise

    def render(self, arrival: Arrival, camera: Camera | None, reason: str) -> tuple[dict[str, Any], bytes]:
        if camera is None:
            raise RequestError(reason)
        message: Any = arrival.checked_message
        try:
            depth = depths(message)
            nearest = self._picture_near(message.header.stamp.to_sec())
            return depth_cloud(depth, camera, None if nearest is None else colours(nearest), self._most, self._numbers)
        except ShapeError as error:
            raise RequestError(f"{self._topic}: {error}") from None

    def change(self, args: Mapping[str, Any]) -> None:
        self._read(args)
        super().change(args)

    def _read(self, args: Mapping[str, Any]) -> None:
        self._most = int(number(args, "most", 1, MAX_POINTS, MAX_POINTS))
        self._numbers = bool(args.get("numbers"))
        colour = text(args, "colour", "").strip()
        if colour != self._colour:
            self._colour = colour
            self._pictures.clear()
            self.listen("colours", colour, self._picture_arrived)

    def _picture_arrived(self, arrival: Arrival) -> None:
        first = not self._pictures
        size = len(arrival.raw._buff)
        while len(self._pictures) > max(0, min(_MAX_PICTURES, KEPT_BYTES // max(1, size)) - 1):
            self._pictures.popleft()
        self._pictures.append(arrival)
        if first:
            self.revision += 1
            self.wake()

    def _picture_near(self, stamp: float) -> Any:
        """Return the colour picture nearest to a time; None if there is none."""
        messages: list[Any] = []
        for arrival in list(self._pictures):
            try:
                check_picture(arrival)
                messages.append(arrival.checked_message)
            except MessageError as error:
                raise RequestError(f"{self._colour}: {error}") from None
        return min(messages, key=lambda each: abs(each.header.stamp.to_sec() - stamp), default=None)
