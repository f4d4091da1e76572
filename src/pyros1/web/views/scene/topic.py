"""Shows a topic's messages in a 3D scene."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, MessageError
from pyros1.web.hub import Arrival
from pyros1.web.scene.clouds import MAX_POINTS
from pyros1.web.scene.grids import UPDATES_SUFFIX, Grid
from pyros1.web.scene.markers import Markers
from pyros1.web.scene.shape import MAX_MAGNITUDE, Shape, ShapeError
from pyros1.web.scene.shapes import CLOUD_FUNCTIONS, POSELESS_TYPES, SHAPE_FUNCTIONS
from pyros1.web.scene.tf_listener import IDENTITY_POSE
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, number_arg, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MARKER_TYPE, MARKER_ARRAY_TYPE = "visualization_msgs/Marker", "visualization_msgs/MarkerArray"
GRID_TYPE = "nav_msgs/OccupancyGrid"
GRID_UPDATE_TYPE = "map_msgs/OccupancyGridUpdate"
MAX_UPDATES = 100
"""Maximum number of a grid's updates queued for a slow page; beyond that, updates are applied when they arrive."""


class SceneTopicView(View):
    """The newest message on a topic as a shape; on a topic with markers, all markers.

    Args (sent by the page):
        topic: the topic's full name. Updates to an OccupancyGrid are received on ``TOPIC_updates``.
        fixed: the frame in which poses are expressed.
        by: the field that colours a cloud; empty to let the server choose one.
        most: maximum number of points sent per cloud.
        numbers: whether to also send the points' indices in the message, and their values.
        bounds: two values for the ends of a cloud's colour scale; absent or null for the minimum and maximum.

    Pushes a shape (see `pyros1.web.scene.shapes`) with "frame", "stamp" and "pose": the pose of the message's frame at
    the message's time, or null if it is unknown; the message is sent again as soon as the pose is known. For markers,
    pushes ``{"kind": "markers", "new": [...], "gone": [[NS, ID], ...], "poses": {FRAME: POSE}, "all": BOOL}``, where
    unknown poses are null; all markers are sent again as soon as one of these poses is known.
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._topic = string_arg(args, "topic")
        self._read_args(args)
        self._lock = threading.Lock()
        self._newest: Arrival | None = None
        self._updates: list[Arrival] = []
        self._last_pushed: Arrival | None = None
        self._pose_unknown = False  # whether the pose of the current message's frame is unknown
        self._markers: Markers | None = None
        self._unplaced_frames: set[str] = set()  # frames of markers whose poses are unknown
        self._grid: Grid | None = None
        self._grid_lock = threading.Lock()
        self._update_error: Error | None = None  # the problem with the last update, which has yet to be reported
        self._sent_version = 0
        self._problem = ""
        self._unsubscribe_updates: Callable[[], None] | None = None
        self._unwatch = robot.tf_listener.watch(lambda: None)
        try:
            self._unsubscribe = robot.listen(self._topic, self._on_message)
        except BaseException:
            self._unwatch()
            raise

    @property
    def polls_periodically(self) -> bool:  # type: ignore[override]  # markers expire, and transforms may arrive late
        """Whether to call `poll` even if no message has arrived."""
        return self._markers is not None or self._pose_unknown

    def poll(self) -> Push | None:
        if self._problem:
            raise RequestError(self._problem)
        with self._lock:
            arrival, markers = self._newest, self._markers
        if markers is not None:
            return self._poll_markers(markers)
        if arrival is None:
            return None
        type_name = _type_name(arrival)
        if type_name != GRID_TYPE and type_name not in CLOUD_FUNCTIONS and type_name not in SHAPE_FUNCTIONS:
            raise RequestError(f"messages of {type_name} cannot be drawn")
        is_new = arrival is not self._last_pushed
        message: Any = arrival.arrays
        header = message.header
        if self._pose_unknown and not is_new and self._pose(type_name, header) is None:
            return None
        self._last_pushed = arrival
        try:
            shape = (
                self._grid_shape(arrival, is_new) if type_name == GRID_TYPE else self._shape(type_name, message, is_new)
            )
        except (ShapeError, MessageError) as error:
            raise RequestError(f"{self._topic}: {error}") from None
        if shape is None:
            return None
        pose = self._pose(type_name, header)
        if pose is None and self._grid is not None:
            with self._grid_lock:
                self._grid.resend()
        self._pose_unknown = pose is None
        description, blob = shape
        return Push({**description, "frame": header.frame_id, "stamp": header.stamp.to_sec(), "pose": pose}, blob)

    def change(self, args: Mapping[str, Any]) -> None:
        self._read_args(args)
        self._last_pushed = None
        self._sent_version = 0

    def close(self) -> None:
        self._unsubscribe()
        if self._unsubscribe_updates is not None:
            self._unsubscribe_updates()
        self._unwatch()

    def _read_args(self, args: Mapping[str, Any]) -> None:
        self._fixed_frame = string_arg(args, "fixed", "")
        self._colour_field = string_arg(args, "by", "")
        self._max_points = int(number_arg(args, "most", 1, MAX_POINTS, MAX_POINTS))
        self._with_indices = bool(args.get("numbers"))
        self._bounds = _parse_bounds(args.get("bounds"))

    def _pose(self, type_name: str, header: Any) -> list[float] | None:
        if type_name in POSELESS_TYPES:
            return IDENTITY_POSE
        return self.robot.tf_listener.pose(self._fixed_frame, header.frame_id, header.stamp)

    def _shape(self, type_name: str, message: Any, is_new: bool) -> Shape | None:
        if not is_new and not self._pose_unknown:
            return None
        if type_name in CLOUD_FUNCTIONS:
            return CLOUD_FUNCTIONS[type_name](
                message, self._colour_field, self._max_points, self._with_indices, self._bounds
            )
        return SHAPE_FUNCTIONS[type_name](message)

    def _grid_shape(self, arrival: Arrival, is_new: bool) -> Shape | None:
        if self._grid is None:
            self._grid = Grid()
            with suppress(RequestError):  # pages are not allowed to see the updates
                self._unsubscribe_updates = self.robot.listen(self._topic + UPDATES_SUFFIX, self._on_grid_update)
        with self._grid_lock:
            if is_new and self._grid.message is arrival.arrays:
                self._grid.resend()  # the page has requested everything again
            self._apply_updates(self._grid, arrival)
            error, self._update_error = self._update_error, None
            if error is not None:
                self.wake()  # so that the updates that fit are sent
                raise error
            return self._grid.take()

    def _apply_updates(self, grid: Grid, arrival: Arrival) -> None:
        """Apply the queued updates to the grid; store the error if one does not fit, so that it will be reported."""
        with self._lock:
            updates, self._updates = self._updates, []
        message: Any = arrival.arrays
        if grid.message is not message:
            grid.put(message)
        for update in updates:
            if update.arrived_at >= arrival.arrived_at:
                try:
                    grid.update(update.arrays)
                except (ShapeError, MessageError) as error:
                    self._update_error = error

    def _poll_markers(self, markers: Markers) -> Push | None:
        tf_listener = self.robot.tf_listener
        if any(tf_listener.pose(self._fixed_frame, frame) for frame in self._unplaced_frames):
            self._sent_version = 0  # the page could not draw the markers in these frames before
        with self._lock:
            if markers is not self._markers:
                return None
            previous_version = self._sent_version
            self._sent_version, new, removed = markers.changes(self._sent_version, self.robot.node.now().to_sec())
            unplaced = self._unplaced_frames & markers.frames() if self._unplaced_frames and previous_version else set()
        if self._sent_version == previous_version:
            return None
        frames = {marker["frame"] for marker in new}
        poses = {frame: tf_listener.pose(self._fixed_frame, frame) for frame in frames} | dict.fromkeys(unplaced)
        self._unplaced_frames = {frame for frame, pose in poses.items() if pose is None}
        return Push(
            {
                "kind": "markers",
                "new": new,
                "gone": removed if previous_version else [],
                "poses": poses,
                "all": not previous_version,
            }
        )

    def _on_message(self, arrival: Arrival) -> None:
        type_name = _type_name(arrival)
        if type_name in (MARKER_TYPE, MARKER_ARRAY_TYPE):
            try:
                message: Any = arrival.checked_message
                with self._lock:
                    if self._markers is None:
                        self._markers, self._sent_version = Markers(), 0
                    self._markers.apply([message] if type_name == MARKER_TYPE else message.markers, arrival.time)
                self._problem = ""
            except MessageError as error:
                self._problem = str(error)
        else:
            with self._lock:
                self._newest, self._markers, self._problem = arrival, None, ""
        self.wake()

    def _on_grid_update(self, arrival: Arrival) -> None:
        if _type_name(arrival) != GRID_UPDATE_TYPE:
            return
        with self._lock:
            self._updates.append(arrival)
            newest, too_many = self._newest, len(self._updates) > MAX_UPDATES
        if too_many and newest is not None and self._grid is not None and _type_name(newest) == GRID_TYPE:
            with self._grid_lock, suppress(MessageError, ShapeError):  # the grid is invalid, which `poll` reports
                self._apply_updates(self._grid, newest)
        self.wake()


def _parse_bounds(value: Any) -> tuple[float, float] | None:
    if not isinstance(value, list) or len(value) != 2 or not all(isinstance(bound, (int, float)) for bound in value):
        return None
    low, high = map(float, value)
    return (low, high) if abs(low) < MAX_MAGNITUDE and abs(high) < MAX_MAGNITUDE else None


def _type_name(arrival: Arrival) -> str:
    return (arrival.raw._connection_header or {}).get("type", "")
