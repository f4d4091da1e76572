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
from pyros1.web.views.image import check_image
from pyros1.web.views.scene.camera import CameraView
from pyros1.web.views.view import number_arg, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_IMAGES = 4
"""Maximum number of recent colour images kept. The one nearest in time to the depth image provides the colours."""
MAX_IMAGE_BYTES = 32 << 20
"""Maximum total size in bytes of the kept colour images; one image is always kept, whatever its size."""


class SceneDepthView(CameraView):
    """A depth image as a point cloud, with colours from another image.

    Args (sent by the page):
        topic, info, fixed: see `CameraView`; the images are depth images.
        colour: the full name of a topic with colour images from the same viewpoint; empty for none.
        most: approximate maximum number of points sent.
        numbers: whether to also send the points' indices in the image.

    Pushes the result of `pyros1.web.scene.depth.depth_cloud`, with "frame", "stamp" and "pose".
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self._colour_images: deque[Arrival] = deque()
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
            nearest = self._nearest_colour_image(message.header.stamp.to_sec())
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
            self._colour_images.clear()
            self.listen("colours", colour, self._on_colour_image)

    def _on_colour_image(self, arrival: Arrival) -> None:
        is_first = not self._colour_images
        size = len(arrival.raw._buff)
        while len(self._colour_images) > max(0, min(_MAX_IMAGES, MAX_IMAGE_BYTES // max(1, size)) - 1):
            self._colour_images.popleft()
        self._colour_images.append(arrival)
        if is_first:
            self.revision += 1
            self.wake()

    def _nearest_colour_image(self, stamp: float) -> Any:
        """Return the colour image whose stamp is nearest to a time; None if there is no colour image."""
        messages: list[Any] = []
        for arrival in list(self._colour_images):
            try:
                check_image(arrival)
                messages.append(arrival.checked_message)
            except MessageError as error:
                raise RequestError(f"{self._colour_topic}: {error}") from None
        return min(messages, key=lambda message: abs(message.header.stamp.to_sec() - stamp), default=None)
