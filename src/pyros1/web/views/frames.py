"""Shows the tree of coordinate frames."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push
from pyros1.web.transforms.frames import Frames
from pyros1.web.views.view import View

if TYPE_CHECKING:
    from pyros1.web.robot import Robot


_PROBLEM_AGE = 10.0
"""Seconds for which a publisher is reported after it has published something other than transforms."""
_MAX_PROBLEMS = 20


class FramesView(View):
    """Pushes the result of `pyros1.web.transforms.frames.Frames.describe` twice a second, and the "problem" of /tf."""

    period = 0.5
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._lock = threading.Lock()
        self._frames = Frames()
        self._problems: dict[str, tuple[str, float]] = {}  # publisher -> (problem, time of detection)
        self._unsubscribers = [robot.listen("/tf", self._on_tf)]
        try:
            self._unsubscribers.append(robot.listen("/tf_static", self._on_tf_static))
        except BaseException:
            self.close()
            raise

    def poll(self) -> Push | None:
        now = self.robot.node.now().to_sec()
        with self._lock:
            problem = next(
                (text for text, found_at in self._problems.values() if found_at > monotonic() - _PROBLEM_AGE), ""
            )
            return Push({**to_json(self._frames.describe(now)), "problem": problem})

    def close(self) -> None:
        for unsubscribe in self._unsubscribers:
            unsubscribe()

    def _on_tf(self, arrival: Arrival) -> None:
        self._add(arrival, False)

    def _on_tf_static(self, arrival: Arrival) -> None:
        self._add(arrival, True)

    def _add(self, arrival: Arrival, static: bool) -> None:
        publisher = (arrival.raw._connection_header or {}).get("callerid", "")
        try:
            message: Any = arrival.message
            with self._lock:
                self._frames.add(message.transforms, publisher, static, arrival.time)
                self._problems.pop(publisher, None)
        except (MessageError, AttributeError, TypeError) as error:
            text = f"{publisher} publishes something other than transforms: {error}"
            with self._lock:
                self._problems.pop(publisher, None)
                self._problems = {publisher: (text, monotonic()), **dict([*self._problems.items()][:_MAX_PROBLEMS])}


def to_json(description: dict[str, Any]) -> dict[str, Any]:
    """Replace non-finite numbers in a description's transforms, which JSON lacks, with null; return the description."""
    for frame in description["frames"]:
        frame["transform"] = [value if math.isfinite(value) else None for value in frame["transform"]]
    return description
