"""tf2_web_republisher: provides selected transforms to web pages, for which all of /tf would be too much data.

A page requests frames, and receives the transforms of those that have moved: as feedback of the action
``tf2_web_republisher``, or on a separate topic created by the service ``republish_tfs``. The TFClient of roslibjs,
which ros3djs uses, expects this interface (https://wiki.ros.org/tf2_web_republisher).
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Sequence
from time import monotonic
from typing import Any

from pyros1.actions import Server
from pyros1.ground.errors import ServiceRefusal
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.tf2_web_republisher.msg import TFArray, TFSubscriptionAction, TFSubscriptionFeedback
from pyros1.msgs.tf2_web_republisher.srv import RepublishTFs
from pyros1.node import Node
from pyros1.tf import Buffer, TransformException, TransformListener

MAX_PAGES = 200
"""Maximum number of pages that are served at the same time."""
MAX_FRAMES = 1000
"""Maximum number of frames per page."""
_DEFAULT_RATE, _MIN_RATE, _MAX_RATE = 10.0, 0.1, 100.0
_MIN_TIMEOUT = 1.0


class MovedFrames:
    """Finds the requested frames that have moved since they were last returned.

    Args:
        buffer: the buffer of transforms.
        target: the fixed frame of the page.
        sources: the requested frames.
        angle: the threshold in radians. A frame that has rotated by less has not moved.
        distance: the threshold in metres. A frame that has been translated by less has not moved.

    Raises:
        ValueError: a page requests too many frames.
    """

    def __init__(self, buffer: Buffer, target: str, sources: Sequence[str], angle: float, distance: float) -> None:
        if len(sources) > MAX_FRAMES:
            raise ValueError(f"{len(sources)} frames are too many: at most {MAX_FRAMES}")
        self._buffer = buffer
        self._target = target.lstrip("/")
        self._sources = dict.fromkeys(source.lstrip("/") for source in sources)
        self._angle = angle
        self._distance = distance
        self._last_transforms: dict[str, Any] = {}

    def find_moved(self) -> list[TransformStamped]:
        """Return the transforms of the frames that have moved since the last call, except unknown frames."""
        moved = []
        for source in self._sources:
            try:
                transform: Any = self._buffer.lookup_transform(self._target, source)
            except TransformException:
                continue
            last = self._last_transforms.get(source)
            if last is None or self._has_moved(last.transform, transform.transform):
                self._last_transforms[source] = transform
                moved.append(transform)
        return moved

    def _has_moved(self, old: Any, new: Any) -> bool:
        a, b = old.translation, new.translation
        if math.dist((a.x, a.y, a.z), (b.x, b.y, b.z)) > self._distance:
            return True
        p, q = old.rotation, new.rotation
        # The vector part of the rotation between both poses is accurate for small angles, unlike the scalar part.
        vector_part = math.hypot(
            p.w * q.x - p.x * q.w - p.y * q.z + p.z * q.y,
            p.w * q.y - p.y * q.w - p.z * q.x + p.x * q.z,
            p.w * q.z - p.z * q.w - p.x * q.y + p.y * q.x,
        )
        scalar_part = abs(p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w)
        return 2 * math.atan2(vector_part, scalar_part) > self._angle


class Republisher:
    """Provides transforms to web pages until the node shuts down.

    Args:
        node: the node. The action has the node's name.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._buffer = Buffer()
        self._listener = TransformListener(node, self._buffer)
        self._lock = threading.Lock()
        self._page_count = 0
        self._topic_numbers = itertools.count()
        self._server = Server(node, node.name, TFSubscriptionAction, self._on_goal)
        self._service = node.advertise_service("republish_tfs", RepublishTFs, self._on_request)

    def close(self) -> None:
        """Stop serving all pages."""
        self._service.shutdown()
        self._server.close()
        self._listener.close()

    def _add_page(self, subscription: Any) -> tuple[MovedFrames, float]:
        """Register a page. Return its `MovedFrames` and its update period in seconds.

        Raises:
            ValueError: the page requests too many frames, or too many pages are being served.
        """
        moved_frames = MovedFrames(
            self._buffer,
            subscription.target_frame,
            subscription.source_frames,
            subscription.angular_thres,
            subscription.trans_thres,
        )
        rate = min(max(subscription.rate, _MIN_RATE), _MAX_RATE) if subscription.rate > 0 else _DEFAULT_RATE
        with self._lock:
            if self._page_count >= MAX_PAGES:
                raise ValueError(f"{MAX_PAGES} pages are already being served")
            self._page_count += 1
        return moved_frames, 1.0 / rate

    def _remove_page(self) -> None:
        with self._lock:
            self._page_count -= 1

    def _on_goal(self, goal: Any) -> None:
        try:
            moved_frames, period = self._add_page(goal.goal)
        except ValueError as error:
            goal.reject(text=str(error))
            return
        goal.accept()

        def on_timer(_: Any) -> None:
            if goal.cancel_requested:
                timer.shutdown()
                self._remove_page()
                goal.cancel()
            elif moved := moved_frames.find_moved():
                goal.feedback(TFSubscriptionFeedback(moved))

        timer = self._node.timer(period, on_timer)

    def _on_request(self, request: Any) -> str:
        try:
            moved_frames, period = self._add_page(request)
        except ValueError as error:
            raise ServiceRefusal(str(error)) from None
        topic = f"~tf_repub_{next(self._topic_numbers)}"
        publisher = self._node.advertise(topic, TFArray, queue_size=10)
        latest_transforms: dict[str, TransformStamped] = {}
        publisher.watch(
            lambda peer: peer.publish(TFArray(list(latest_transforms.values()))) if latest_transforms else None
        )
        timeout = max(request.timeout.to_sec(), _MIN_TIMEOUT)
        last_subscribed_at = monotonic()

        def on_timer(_: Any) -> None:
            nonlocal last_subscribed_at, latest_transforms
            if publisher.num_connections:
                last_subscribed_at = monotonic()
            elif monotonic() - last_subscribed_at > timeout:
                timer.shutdown()
                publisher.unregister()
                self._remove_page()
                return
            if moved := moved_frames.find_moved():
                # Replaced with a new dictionary, since another thread reads the old one.
                latest_transforms = latest_transforms | {transform.child_frame_id: transform for transform in moved}
                publisher.publish(TFArray(moved))

        timer = self._node.timer(period, on_timer)
        return self._node.resolve(topic)


def main(argv: list[str]) -> int:
    """Run the program. Return its exit code.

    Args:
        argv: the command line, including the program's name.
    """
    with Node("tf2_web_republisher", argv=argv[1:]) as node:
        Republisher(node)
        node.spin()
    return 0
