"""What a topic's messages look like in a 3D scene."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.web.hub import Arrival
from pyros1.web.scene.markers import Markers
from pyros1.web.scene.shapes import SHAPES, ShapeError
from pyros1.web.views.view import View, text
from pyros1.web.wire import Push, RequestError

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MARKERS = {"visualization_msgs/Marker", "visualization_msgs/MarkerArray"}


class SceneTopicView(View):
    """The newest message of a topic as a shape, or its markers.

    Args (of the page):
        topic: the topic's full name.
        fixed: the frame in which the pose is told.

    Pushes the facts of `pyros1.web.scene.shapes` with "frame", "stamp" and "pose", the place of the message's frame at
    its time, or null if that is not known; or
    ``{"kind": "markers", "new": [...], "gone": [[NS, ID], ...], "poses": {FRAME: POSE}, "all": BOOL}``.
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._fixed = text(args, "fixed", "")
        self._topic = text(args, "topic")
        self._lock = threading.Lock()
        self._newest: Arrival | None = None
        self._shown: Arrival | None = None
        self._markers: Markers | None = None
        self._seen = 0
        self._problem = ""
        self._look = robot.world.look(lambda: None)
        try:
            self._end = robot.listen(self._topic, self._arrived)
        except BaseException:
            self._look()
            raise

    @property
    def polled(self) -> bool:  # type: ignore[override]  # of markers: they end after their lifetimes
        """Whether to ask `take` also if no message has come."""
        return self._markers is not None

    def take(self) -> Push | None:
        if self._markers is not None:
            return self._changed_markers(self._markers)
        with self._lock:
            arrival = self._newest
        if self._problem:
            raise RequestError(self._problem)
        if arrival is None or arrival is self._shown:
            return None
        self._shown = arrival
        kind = _type(arrival)
        shape = SHAPES.get(kind)
        if shape is None:
            raise RequestError(f"messages of {kind} cannot be drawn")
        message: Any = arrival.message
        try:
            facts, blob = shape(message)
        except ShapeError as error:
            raise RequestError(f"{self._topic}: {error}") from None
        header = message.header
        pose = self.robot.world.pose(self._fixed, header.frame_id, header.stamp)
        facts |= {"frame": header.frame_id, "stamp": header.stamp.to_sec(), "pose": pose}
        return Push(facts, blob)

    def change(self, args: Mapping[str, Any]) -> None:
        self._fixed = text(args, "fixed", "")
        self._shown = None
        self._seen = 0

    def close(self) -> None:
        self._end()
        self._look()

    def _changed_markers(self, markers: Markers) -> Push | None:
        with self._lock:
            before = self._seen
            self._seen, new, gone = markers.changes(self._seen, self.robot.node.now().to_sec())
        if self._seen == before:
            return None
        frames = {marker["frame"] for marker in new}
        poses = {frame: self.robot.world.pose(self._fixed, frame) for frame in frames}
        return Push({"kind": "markers", "new": new, "gone": gone if before else [], "poses": poses, "all": not before})

    def _arrived(self, arrival: Arrival) -> None:
        if _type(arrival) in MARKERS:
            try:
                message: Any = arrival.message
            except MessageError as error:
                self._problem = str(error)
                return
            with self._lock:
                if self._markers is None:
                    self._markers = Markers()
                self._markers.add(getattr(message, "markers", None) or [message], arrival.time)
        else:
            with self._lock:
                self._newest = arrival
        self.wake()


def _type(arrival: Arrival) -> str:
    return (arrival.raw._connection_header or {}).get("type", "")
