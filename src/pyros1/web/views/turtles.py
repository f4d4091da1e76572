"""Shows a turtlesim_node's turtles and what they have drawn."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from math import isfinite
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.turtlesim.finding import drawing_topic, find_simulators
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.image import page_image
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.hub import Arrival
    from pyros1.web.robot import Robot

_REFRESH_PERIOD = 1.0
"""Seconds between checks for new turtles."""


class TurtlesView(View):
    """The turtles of a node: their poses, and their drawing, which stock turtlesim does not publish.

    Args (sent by the page):
        node: the node's name; empty for the first turtlesim_node found.

    Pushes the parts that have changed of ``{"facts": {"node", "nodes", "there"}, "turtles": {name: [x, y, theta]},
    "drawing": {...}}``, and with "drawing" (see `pyros1.web.views.image.page_image`), the image's data.
    """

    period = 1 / 30
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._requested_node = string_arg(args, "node", "")
        self._lock = threading.Lock()  # guards the received data
        self._poses: dict[str, Arrival] = {}
        self._drawing: Arrival | None = None
        self._last_drawing: Arrival | None = None
        self._last_pushed: dict[str, Any] = {}
        self._node_info: dict[str, Any] = {}
        self._turtles: list[str] = []
        self._unsubscribers: dict[str, Callable[[], None]] = {}  # by topic
        self._refreshed_at = float("-inf")

    def poll(self) -> Push | None:
        if monotonic() - self._refreshed_at >= _REFRESH_PERIOD:
            self._refresh()
            self._refreshed_at = monotonic()
        with self._lock:
            poses, drawing = dict(self._poses), self._drawing
        current = {
            "facts": self._node_info,
            "turtles": {name: _read_pose(poses[name]) for name in self._turtles if name in poses},
        }
        changed: dict[str, Any] = {key: value for key, value in current.items() if value != self._last_pushed.get(key)}
        blob = None
        if drawing is not None and drawing is not self._last_drawing:
            self._last_drawing = drawing
            changed["drawing"], blob = page_image(drawing)
        self._last_pushed = current
        return Push(changed, blob) if changed else None

    def change(self, args: Mapping[str, Any]) -> None:
        self._requested_node = string_arg(args, "node", "")
        self._refreshed_at = float("-inf")

    def close(self) -> None:
        for unsubscribe in self._unsubscribers.values():
            unsubscribe()

    def _refresh(self) -> None:
        graph = self.robot.graph
        simulators = find_simulators(graph.published_types(), graph.state().publishers)
        may_see = self.robot.access.may_see
        simulators = {
            node: {name: topic for name, topic in turtles.items() if may_see(topic)}
            for node, turtles in simulators.items()
        }
        nodes = [node for node, turtles in simulators.items() if turtles]
        node = self._requested_node or next(iter(nodes), "")
        turtles = simulators.get(node, {})
        drawing = drawing_topic(node)
        topics: dict[str, Callable[[Arrival], None]] = {
            topic: self._make_pose_listener(name) for name, topic in turtles.items()
        }
        if turtles and may_see(drawing):
            topics[drawing] = self._on_drawing
        for topic in self._unsubscribers.keys() - topics.keys():
            self._unsubscribers.pop(topic)()
        if node != self._node_info.get("node"):
            with self._lock:
                self._poses, self._drawing = {}, None
        for topic in topics.keys() - self._unsubscribers.keys():
            with suppress(RequestError):
                self._unsubscribers[topic] = self.robot.listen(topic, topics[topic])
        self._turtles = list(turtles)
        self._node_info = {"node": node, "nodes": nodes, "there": bool(turtles)}

    def _make_pose_listener(self, name: str) -> Callable[[Arrival], None]:
        def listener(arrival: Arrival) -> None:
            with self._lock:
                self._poses[name] = arrival

        return listener

    def _on_drawing(self, arrival: Arrival) -> None:
        with self._lock:
            self._drawing = arrival


def _read_pose(arrival: Arrival) -> list[float] | None:
    with suppress(MessageError, AttributeError):
        pose: Any = arrival.checked_message
        numbers = [float(pose.x), float(pose.y), float(pose.theta)]
        return numbers if isfinite(sum(numbers)) else None
    return None
