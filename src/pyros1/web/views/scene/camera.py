"""The pictures of a camera and its pose."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.web.hub import Arrival
from pyros1.web.scene.camera import Camera, info_topic, pinhole
from pyros1.web.scene.shape import ShapeError
from pyros1.web.server.wire import Push
from pyros1.web.views.image import COMPRESSED, check_picture, picture
from pyros1.web.views.view import View, text

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_INFO = "sensor_msgs/CameraInfo"
_STAMP_SIZE = 12
"""Bytes of a message that differ even if its content is the same: sequence number and stamp of its header."""


class CameraView(View):
    """The newest picture of a topic with its camera: the base of camera views.

    Args (of the page):
        topic: the full name of a topic with pictures.
        info: the full name of the topic of its CameraInfo; empty for the one next to it.
        fixed: the frame in which the camera's pose is expressed.
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._topic = text(args, "topic")
        self._fixed = text(args, "fixed", "")
        self._requested_info = text(args, "info", "").strip()
        self._lock = threading.Lock()
        self._unsubscribers: dict[str, Callable[[], None]] = {"world": robot.world.watch(lambda: None)}
        self._newest: Arrival | None = None
        self._info: Arrival | None = None
        self._info_topic = ""  # the topic of the CameraInfo that is subscribed to
        self.revision = 0
        """Increment this to have `render` called again with the same picture."""
        self._last_shown: tuple[Arrival, Arrival | None, int] | None = None
        self._pose_unknown = False
        try:
            self._unsubscribers["pictures"] = robot.listen(self._topic, self._arrived)
        except BaseException:
            self.close()
            raise

    @property
    def polled(self) -> bool:  # type: ignore[override]  # frames arrive late
        """Whether to call `poll` even if no message has arrived."""
        return self._pose_unknown

    def poll(self) -> Push | None:
        with self._lock:
            arrival = self._newest
        if arrival is None:
            return None
        check_picture(arrival)
        self._subscribe_to_info(_type(arrival) == COMPRESSED)
        with self._lock:
            now = (arrival, self._info, self.revision)
        header = arrival.checked_message.header  # type: ignore[attr-defined]
        pose = self.robot.world.pose(self._fixed, header.frame_id, header.stamp)
        if now == self._last_shown and not (self._pose_unknown and pose is not None):
            return None
        self._last_shown, self._pose_unknown = now, pose is None
        facts, blob = self.render(arrival, *self._camera(now[1]))
        return Push({**facts, "frame": header.frame_id, "stamp": header.stamp.to_sec(), "pose": pose}, blob)

    @abstractmethod
    def render(self, arrival: Arrival, camera: Camera | None, reason: str) -> tuple[dict[str, Any], bytes]:
        """Return the facts and bytes to push for a picture.

        Args:
            arrival: the picture.
            camera: its camera; None if unknown.
            reason: why the camera is unknown.

        Raises:
            RequestError: it cannot be displayed.
        """

    def change(self, args: Mapping[str, Any]) -> None:
        self._fixed = text(args, "fixed", "")
        self._requested_info = text(args, "info", "").strip()
        self._last_shown = None

    def close(self) -> None:
        for unsubscribe in self._unsubscribers.values():
            unsubscribe()
        self._unsubscribers = {}

    def listen(self, name: str, topic: str, listener: Callable[[Arrival], object]) -> None:
        """Listen to a topic, replacing the previous one under this name; to none if it is empty."""
        self._unsubscribers.pop(name, lambda: None)()
        if topic:
            self._unsubscribers[name] = self.robot.listen(topic, listener)

    def _subscribe_to_info(self, compressed: bool) -> None:
        topic = self._requested_info or info_topic(self._topic, compressed)
        if topic == self._info_topic:
            return
        with self._lock:
            self._info = None
        self._info_topic = topic
        self.listen("info", topic, self._info_arrived)

    def _camera(self, info: Arrival | None) -> tuple[Camera | None, str]:
        if info is None:
            return None, f"no CameraInfo has been received on {self._info_topic}"
        if _type(info) != _INFO:
            return None, f"{self._info_topic} has no CameraInfo, but {_type(info)}"
        try:
            return pinhole(info.checked_message), ""
        except (ShapeError, MessageError) as error:
            return None, f"{self._info_topic}: {error}"

    def _arrived(self, arrival: Arrival) -> None:
        with self._lock:
            self._newest = arrival
        self.wake()

    def _info_arrived(self, arrival: Arrival) -> None:
        with self._lock:
            known, self._info = self._info, arrival
            same = known is not None and known.raw._buff[_STAMP_SIZE:] == arrival.raw._buff[_STAMP_SIZE:]
            if same:
                self._info = known  # the same is sent again with each picture
        if not same:
            self.wake()


class SceneCameraView(CameraView):
    """A camera's pictures and their pose.

    Pushes the result of `pyros1.web.views.image.picture`, with the "camera": fx, fy, cx, cy, tx, ty, width and height
    of `pyros1.web.scene.camera.Camera`, or null, and "why"; with the "pose" of its frame when the picture was taken, or
    null; and with the data of the picture.
    """

    def render(self, arrival: Arrival, camera: Camera | None, reason: str) -> tuple[dict[str, Any], bytes]:
        facts, data = picture(arrival)
        return {**facts, "camera": asdict(camera) if camera else None, "why": reason}, data


def _type(arrival: Arrival) -> str:
    return (arrival.raw._connection_header or {}).get("type", "")
