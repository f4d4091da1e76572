"""Looks up the sensors' frames with tf, and caches their matrices."""

from __future__ import annotations

import threading
import time
from typing import Any

from pyros1.ground.timing import Time
from pyros1.node import Node
from pyros1.robot_nodes.robot_localization.sensors import Frame
from pyros1.tf.errors import TransformException
from pyros1.tf.rotation import Transform

MAX_FRAMES = 1000
"""Maximum number of cached pairs of frames."""
_GRACE = 2.0
"""Seconds after the start of the listener during which missing frames are not reported."""


class Frames:
    """Looks up frames. Listens to tf only once it is needed, since the sensors of many robots need no conversion.

    Args:
        node: the node that listens and logs.
        timeout: how long to wait for a transform, in seconds.
    """

    def __init__(self, node: Node, timeout: float = 0.0) -> None:
        self._node = node
        self._timeout = timeout
        self._lock = threading.Lock()
        self._buffer: Any = None
        self._quiet_until = 0.0
        self._known: dict[tuple[str, str], Frame] = {}
        self._identity = Frame()

    def find(self, target: str, source: str, time: int) -> Frame | None:
        """Return the pose of the source frame in the target frame; None, with a warning in the log, if it is unknown.

        If it is not known for that time, the latest pose is returned.

        Args:
            target: the frame to convert to.
            source: the frame to convert from.
            time: the time in nanoseconds.
        """
        target, source = target.lstrip("/"), source.lstrip("/")
        if target == source:
            return self._identity
        transform = self._look_up(target, source, time)
        if transform is None:
            return None
        frame = self._known.get((target, source))
        if frame is None or frame.transform != transform:
            if len(self._known) >= MAX_FRAMES:
                self._known.clear()
            frame = self._known[target, source] = Frame(transform)
        return frame

    def _look_up(self, target: str, source: str, time_ns: int) -> Transform | None:
        buffer = self._listen()
        try:
            try:
                stamped = buffer.lookup_transform(target, source, Time.from_nsec(time_ns), self._timeout or None)
            except TransformException:
                stamped = buffer.lookup_transform(target, source)
        except TransformException as error:
            if time.monotonic() >= self._quiet_until:
                text = "data in the frame %s cannot be converted to %s: %s"
                self._node.log.warn(text, source, target, error, throttle=30)
            return None
        position, rotation = stamped.transform.translation, stamped.transform.rotation
        return (position.x, position.y, position.z, rotation.x, rotation.y, rotation.z, rotation.w)

    def _listen(self) -> Any:
        with self._lock:
            if self._buffer is None:
                from pyros1.tf import Buffer, TransformListener  # noqa: PLC0415 - not needed by many robots

                self._buffer = Buffer()
                TransformListener(self._node, self._buffer)
                self._quiet_until = time.monotonic() + _GRACE
            return self._buffer
