"""Shows a camera's images in a 3D scene, with the camera's pose."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.web.hub import Arrival
from pyros1.web.scene.camera import Camera, camera_info_topic, pinhole_camera
from pyros1.web.scene.shape import ShapeError
from pyros1.web.server.wire import Push
from pyros1.web.views.image import COMPRESSED_TYPE, check_image, page_image
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_CAMERA_INFO_TYPE = "sensor_msgs/CameraInfo"
_STAMP_SIZE = 12
"""Number of bytes at the start of a message that differ even if it is repeated: sequence number and stamp."""


class CameraView(View):
    """Base class of the views of cameras: the newest image on a topic, and the camera that took it.

    Args (sent by the page):
        topic: the full name of a topic with images.
        info: the full name of the CameraInfo topic; empty for the topic ``camera_info`` in the same namespace.
        fixed: the frame in which the camera's pose is expressed.
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._topic = string_arg(args, "topic")
        self._fixed_frame = string_arg(args, "fixed", "")
        self._requested_info_topic = string_arg(args, "info", "").strip()
        self._lock = threading.Lock()
        self._unsubscribers: dict[str, Callable[[], None]] = {"tf": robot.tf_listener.watch(lambda: None)}
        self._newest: Arrival | None = None
        self._info: Arrival | None = None
        self._info_topic = ""  # the CameraInfo topic to which the view has subscribed
        self.revision = 0
        """Increment this to call `render` again with the same image."""
        self._last_pushed: tuple[Arrival, Arrival | None, int] | None = None
        self._pose_unknown = False
        try:
            self._unsubscribers["images"] = robot.listen(self._topic, self._on_image)
        except BaseException:
            self.close()
            raise

    @property
    def polls_periodically(self) -> bool:  # type: ignore[override]  # transforms may arrive late
        """Whether to call `poll` even if no message has arrived."""
        return self._pose_unknown

    def poll(self) -> Push | None:
        with self._lock:
            arrival = self._newest
        if arrival is None:
            return None
        check_image(arrival)
        self._subscribe_to_info(_type_name(arrival) == COMPRESSED_TYPE)
        with self._lock:
            current = (arrival, self._info, self.revision)
        header = arrival.checked_message.header  # type: ignore[attr-defined]
        pose = self.robot.tf_listener.pose(self._fixed_frame, header.frame_id, header.stamp)
        if current == self._last_pushed and not (self._pose_unknown and pose is not None):
            return None
        self._last_pushed, self._pose_unknown = current, pose is None
        description, blob = self.render(arrival, *self._read_camera(current[1]))
        return Push({**description, "frame": header.frame_id, "stamp": header.stamp.to_sec(), "pose": pose}, blob)

    @abstractmethod
    def render(self, arrival: Arrival, camera: Camera | None, reason: str) -> tuple[dict[str, Any], bytes]:
        """Return the data and the bytes to push for an image.

        Args:
            arrival: the image.
            camera: the camera that took the image; None if it is unknown.
            reason: why the camera is unknown; empty if it is known.

        Raises:
            RequestError: the image cannot be displayed.
        """

    def change(self, args: Mapping[str, Any]) -> None:
        self._fixed_frame = string_arg(args, "fixed", "")
        self._requested_info_topic = string_arg(args, "info", "").strip()
        self._last_pushed = None

    def close(self) -> None:
        for unsubscribe in self._unsubscribers.values():
            unsubscribe()
        self._unsubscribers = {}

    def listen(self, name: str, topic: str, listener: Callable[[Arrival], object]) -> None:
        """Listen to a topic instead of the last one passed with this `name`; for an empty topic, stop listening."""
        self._unsubscribers.pop(name, lambda: None)()
        if topic:
            self._unsubscribers[name] = self.robot.listen(topic, listener)

    def _subscribe_to_info(self, compressed: bool) -> None:
        topic = self._requested_info_topic or camera_info_topic(self._topic, compressed)
        if topic == self._info_topic:
            return
        with self._lock:
            self._info = None
        self._info_topic = topic
        self.listen("info", topic, self._on_info)

    def _read_camera(self, info: Arrival | None) -> tuple[Camera | None, str]:
        if info is None:
            return None, f"no CameraInfo has been received on {self._info_topic}"
        if _type_name(info) != _CAMERA_INFO_TYPE:
            return None, f"the type of {self._info_topic} is not {_CAMERA_INFO_TYPE}, but {_type_name(info)}"
        try:
            return pinhole_camera(info.checked_message), ""
        except (ShapeError, MessageError) as error:
            return None, f"{self._info_topic}: {error}"

    def _on_image(self, arrival: Arrival) -> None:
        with self._lock:
            self._newest = arrival
        self.wake()

    def _on_info(self, arrival: Arrival) -> None:
        with self._lock:
            previous, self._info = self._info, arrival
            is_same = previous is not None and previous.raw._buff[_STAMP_SIZE:] == arrival.raw._buff[_STAMP_SIZE:]
            if is_same:
                self._info = previous  # the same message is sent again with each image
        if not is_same:
            self.wake()


class SceneCameraView(CameraView):
    """A camera's images, and its pose.

    Pushes the result of `pyros1.web.views.image.page_image`, with "camera" (the attributes of
    `pyros1.web.scene.camera.Camera`, or null), "why" (why it is null), and "pose" (the pose of the camera's frame when
    the image was taken, or null).
    """

    def render(self, arrival: Arrival, camera: Camera | None, reason: str) -> tuple[dict[str, Any], bytes]:
        description, data = page_image(arrival)
        return {**description, "camera": asdict(camera) if camera else None, "why": reason}, data


def _type_name(arrival: Arrival) -> str:
    return (arrival.raw._connection_header or {}).get("type", "")
