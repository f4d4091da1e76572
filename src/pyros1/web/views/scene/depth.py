"""Shows a camera's depth images as point clouds in a 3D scene."""

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
from pyros1.web.views.view import number_arg, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_PICTURES = 4
"""Maximum number of recent colour pictures kept. The one nearest in time to the depth image provides the colours."""
MAX_PICTURE_BYTES = 32 << 20
"""Maximum total size in bytes of the kept colour pictures; one picture is always kept, whatever its size."""


class SceneDepthView(CameraView):
    """A depth image as a point cloud, with colours from another picture.

    Args (of the page):
        topic, info, fixed: see `CameraView`; the pictures are depth images.
        colour: the full name of a topic with colour pictures from the same viewpoint; empty for none.
        most: approximate maximum number of points sent.
        numbers: whether to also send the points' indices in the picture.

    Pushes the result of `pyros1.web.scene.depth.depth_cloud`, with "frame", "stamp" and "pose".
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self._pictures: deque[Arrival] = deque()
        self._colour_topic = ""
        super().__init__(robot, args, wake)
        try:
            self._read_args(args)
        except BaseException:
            self.close()
            raise

    def render(self, arrival: Arrival, camera: Camera | None, reason: str) -> tuple[dict[str, Any], bytes]:
        if camera is None:
            raise RequestError(reason)
        message: Any = arrival.checked_message
        try:
            depth = depths(message)
            nearest = self._nearest_picture(message.header.stamp.to_sec())
            return depth_cloud(
                depth, camera, None if nearest is None else colours(nearest), self._max_points, self._with_indices
            )
        except ShapeError as error:
            raise RequestError(f"{self._topic}: {error}") from None

    def change(self, args: Mapping[str, Any]) -> None:
        self._read_args(args)
        super().change(args)

    def _read_args(self, args: Mapping[str, Any]) -> None:
        self._max_points = int(number_arg(args, "most", 1, MAX_POINTS, MAX_POINTS))
        self._with_indices = bool(args.get("numbers"))
        colour = string_arg(args, "colour", "").strip()
        if colour != self._colour_topic:
            self._colour_topic = colour
            self._pictures.clear()
            self.listen("colours", colour, self._on_picture_colours)

    def _on_picture_colours(self, arrival: Arrival) -> None:
        is_first = not self._pictures
        size = len(arrival.raw._buff)
        while len(self._pictures) > max(0, min(_MAX_PICTURES, MAX_PICTURE_BYTES // max(1, size)) - 1):
            self._pictures.popleft()
        self._pictures.append(arrival)
        if is_first:
            self.revision += 1
            self.wake()

    def _nearest_picture(self, stamp: float) -> Any:
        """Return the colour picture whose stamp is nearest to a time; None if there is no colour picture."""
        messages: list[Any] = []
        for arrival in list(self._pictures):
            try:
                check_picture(arrival)
                messages.append(arrival.checked_message)
            except MessageError as error:
                raise RequestError(f"{self._colour_topic}: {error}") from None
        return min(messages, key=lambda message: abs(message.header.stamp.to_sec() - stamp), default=None)
