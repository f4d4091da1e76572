"""Shows the interactive markers on a topic in a 3D scene."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.web.hub import Arrival
from pyros1.web.scene.interactive import InteractiveMarkers
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MESSAGE_TYPES = {"visualization_msgs/InteractiveMarkerInit", "visualization_msgs/InteractiveMarkerUpdate"}
RESUBSCRIBE_PERIOD = 2.0
"""Minimum number of seconds between subscriptions that request all markers again, after updates were missed."""


class SceneInteractiveView(View):
    """The interactive markers on a topic.

    Args (sent by the page):
        topic: the full name of the topic with updates, which ends in ``/update``.

    Pushes ``{"kind": "interactive", "all": BOOL, "new": [...], "moved": [...], "gone": [[SERVER, NAME], ...]}``; see
    `pyros1.web.scene.interactive`. Poses are in the markers' frames.
    """

    polls_periodically = True  # since servers may disappear without notice

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._base_topic = string_arg(args, "topic").removesuffix("/update")
        self._lock = threading.Lock()
        self._markers = InteractiveMarkers()
        self._sent_version = -1
        self._problem = ""
        self._missed_updates = False
        self._resubscribed_at = monotonic()
        self._unsubscribe_full = robot.listen(f"{self._base_topic}/update_full", self._on_message)
        try:
            self._unsubscribe = robot.listen(f"{self._base_topic}/update", self._on_message)
        except BaseException:
            self._unsubscribe_full()
            raise

    def poll(self) -> Push | None:
        now = monotonic()
        if self._missed_updates and now > self._resubscribed_at + RESUBSCRIBE_PERIOD:
            self._missed_updates, self._resubscribed_at = False, now
            self._unsubscribe_full()  # a new subscription receives the latched message
            self._unsubscribe_full = self.robot.listen(f"{self._base_topic}/update_full", self._on_message)
        if self._problem:
            raise RequestError(self._problem)
        with self._lock:
            self._markers.remove_expired(now)
            previous_version = self._sent_version
            self._sent_version, new, moved_markers, removed = self._markers.changes(max(0, previous_version))
        if self._sent_version == previous_version:
            return None
        is_first = previous_version < 0
        return Push({"kind": "interactive", "all": is_first, "new": new, "moved": moved_markers, "gone": removed})

    def change(self, args: Mapping[str, Any]) -> None:
        """Send all markers again."""
        self._sent_version = -1

    def close(self) -> None:
        self._unsubscribe()
        self._unsubscribe_full()

    def _on_message(self, arrival: Arrival) -> None:
        type_name = (arrival.raw._connection_header or {}).get("type", "")
        if type_name not in _MESSAGE_TYPES:
            self._problem = f"the type of {self._base_topic} is not that of interactive markers, but {type_name}"
            return
        try:
            message: Any = arrival.checked_message
        except MessageError as error:
            self._problem = str(error)
            return
        with self._lock:
            self._problem = ""
            if type_name.endswith("Init"):
                self._markers.init(message, monotonic())
            elif not self._markers.update(message, monotonic()):
                self._missed_updates = True
        self.wake()
