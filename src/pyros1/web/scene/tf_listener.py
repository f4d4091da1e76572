"""Keeps the robot's transforms in a tf buffer that the scenes of all pages share, while any page displays a scene."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.tf.buffer import Buffer
from pyros1.tf.errors import TransformException
from pyros1.web.hub import Arrival
from pyros1.web.scene.shape import MAX_MAGNITUDE

Listen = Callable[[str, Callable[[Arrival], object]], Callable[[], None]]
Pose = list[float]
"""Position x, y, z in metres, and a quaternion x, y, z, w."""
MAX_FRAMES = 5_000
"""Maximum number of frames kept; further frames are ignored."""
_MAX_STAMP_STEP_BACK = 5.0
"""Seconds: if a publisher's stamps jump back by more than this, a bag or a simulation has restarted."""
_MAX_CLOCK_STEP_BACK = 0.1
"""Like `_MAX_STAMP_STEP_BACK`, but for the node's clock, which a bag or a simulation may control."""
IDENTITY_POSE: Pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


class TfListener:
    """Receives the robot's transforms into a buffer as long as something watches them.

    Args:
        listen: see `pyros1.web.robot.Robot.listen`.
    """

    def __init__(self, listen: Listen) -> None:
        self._listen = listen
        self._lock = threading.Lock()
        self._num_watchers = 0
        self._unsubscribers: list[Callable[[], None]] = []
        self._listeners: tuple[Callable[[], object], ...] = ()
        self._newest_stamps: dict[str, float] = {}
        self._newest_time = float("-inf")
        self.buffer = Buffer(warn=lambda text: None)

    def watch(self, listener: Callable[[], object]) -> Callable[[], None]:
        """Add a listener, and fill the buffer from now on.

        Args:
            listener: called after each change, in a thread of the node.

        Returns:
            A function that removes the listener. When the last listener is removed, the buffer is no longer filled.
        """
        with self._lock:
            if not self._num_watchers:
                self.buffer = Buffer(warn=lambda text: None)
                self._newest_stamps, self._newest_time = {}, float("-inf")
                self._unsubscribers.append(self._listen("/tf", self._on_tf))
                try:
                    self._unsubscribers.append(self._listen("/tf_static", self._on_tf_static))
                except BaseException:
                    self._unsubscribers.pop()()
                    raise
            self._num_watchers += 1
            self._listeners = (*self._listeners, listener)
        is_unwatched = False

        def unwatch() -> None:
            nonlocal is_unwatched
            with self._lock:
                if is_unwatched:
                    return
                is_unwatched = True
                self._listeners = tuple(other for other in self._listeners if other is not listener)
                self._num_watchers -= 1
                unsubscribers, self._unsubscribers = (
                    (self._unsubscribers, []) if not self._num_watchers else ([], self._unsubscribers)
                )
            for unsubscribe in unsubscribers:
                unsubscribe()

        return unwatch

    def pose(self, fixed_frame: str, frame: str, stamp: Time | None = None) -> Pose | None:
        """Return a frame's pose in another frame.

        Args:
            fixed_frame: the frame in which the pose is expressed.
            frame: the frame whose pose is returned.
            stamp: the time; None for the latest time, which is also used if the buffer has no data for the given time.

        Returns:
            The pose; None if the frames are not connected, or a transform has non-finite numbers.
        """
        fixed_frame, frame = fixed_frame.lstrip("/"), frame.lstrip("/")
        if fixed_frame == frame:
            return list(IDENTITY_POSE)
        for time in (stamp, None) if stamp else (None,):
            try:
                stamped_transform = self.buffer.lookup_transform(fixed_frame, frame, time)
            except TransformException:
                continue
            translation, rotation = stamped_transform.transform.translation, stamped_transform.transform.rotation
            pose = [translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z, rotation.w]
            return pose if all(abs(value) < MAX_MAGNITUDE for value in pose) else None
        return None

    def _reset_if_time_jumped_back(self, transforms: Any, publisher: str, now: float) -> None:
        stamps = [transform.header.stamp.to_sec() for transform in transforms]
        if not stamps:
            return
        newest = self._newest_stamps.get(publisher, 0.0)
        previous, self._newest_time = self._newest_time, now
        if max(stamps) < newest - _MAX_STAMP_STEP_BACK or now < previous - _MAX_CLOCK_STEP_BACK:
            self.buffer.clear()  # except for static transforms
            self._newest_stamps.clear()
        if len(self._newest_stamps) < MAX_FRAMES or publisher in self._newest_stamps:
            self._newest_stamps[publisher] = max(*stamps, self._newest_stamps.get(publisher, 0.0))

    def _on_tf(self, arrival: Arrival) -> None:
        self._add(arrival, False)

    def _on_tf_static(self, arrival: Arrival) -> None:
        self._add(arrival, True)

    def _add(self, arrival: Arrival, static: bool) -> None:
        try:
            message: Any = arrival.message
            self._store(message.transforms, arrival, static)
        except (MessageError, AttributeError, TypeError):
            return  # the message does not contain transforms; the frames panel reports this
        for listener in self._listeners:
            listener()

    def _store(self, transforms: Any, arrival: Arrival, static: bool) -> None:
        publisher = (arrival.raw._connection_header or {}).get("callerid", "")
        if not static:
            self._reset_if_time_jumped_back(transforms, publisher, arrival.time)
        if len(self.buffer.frames()) > MAX_FRAMES:
            transforms = [
                transform for transform in transforms if self.buffer.has_frame(transform.child_frame_id.lstrip("/"))
            ]
        self.buffer.set_transforms(transforms, publisher, static=static)
