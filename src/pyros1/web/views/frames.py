"""The tree of coordinate frames."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push
from pyros1.web.shown.frames import Frames
from pyros1.web.views.view import View

if TYPE_CHECKING:
    from pyros1.web.robot import Robot


class FramesView(View):
    """What `pyros1.web.shown.frames.Frames.describe` returns, twice a second, and "problem", of /tf itself."""

    period = 0.5
    polled = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._lock = threading.Lock()
        self._frames = Frames()
        self._problem = ""
        self._ends = [robot.listen("/tf", self._moving)]
        try:
            self._ends.append(robot.listen("/tf_static", self._static))
        except BaseException:
            self.close()
            raise

    def take(self) -> Push | None:
        now = self.robot.node.now().to_sec()
        with self._lock:
            return Push({**plain(self._frames.describe(now)), "problem": self._problem})

    def close(self) -> None:
        for end in self._ends:
            end()

    def _moving(self, arrival: Arrival) -> None:
        self._add(arrival, False)

    def _static(self, arrival: Arrival) -> None:
        self._add(arrival, True)

    def _add(self, arrival: Arrival, static: bool) -> None:
        publisher = (arrival.raw._connection_header or {}).get("callerid", "")
        try:
            message: Any = arrival.message
            with self._lock:
                self._frames.add(message.transforms, publisher, static, arrival.time)
        except (MessageError, AttributeError, TypeError) as error:
            self._problem = f"{publisher} publishes something else than transforms: {error}"


def plain(facts: dict[str, Any]) -> dict[str, Any]:
    """Replace the numbers that JSON does not have."""
    for frame in facts["frames"]:
        frame["transform"] = [value if math.isfinite(value) else None for value in frame["transform"]]
    return facts
