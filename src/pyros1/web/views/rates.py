"""Rates of topics that nobody else subscribes to: their publishers send nothing that could be counted."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error
from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MOST_TOPICS = 50
_WINDOW = 5.0
"""Seconds over which a rate is measured."""
_MOST_TIMES = 5_000


class RatesView(View):
    """How much comes on topics.

    Args (of the page):
        topics: a list of full names.

    Pushes ``{TOPIC: {"hz": N, "bytes": N per second} or {"problem": TEXT}}``.
    """

    period = 1.0
    polled = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._meters: dict[str, _Meter] = {}
        self._ends: dict[str, Callable[[], None]] = {}
        self._problems: dict[str, str] = {}
        self.change(args)

    def change(self, args: Mapping[str, Any]) -> None:
        topics = args.get("topics", [])
        if not isinstance(topics, list) or len(topics) > MOST_TOPICS or not all(isinstance(x, str) for x in topics):
            raise RequestError(f"at most {MOST_TOPICS} topics are measured at the same time")
        for topic in self._meters.keys() - topics:
            self._forget(topic)
        self._problems = {}
        for topic in topics:
            if topic in self._meters:
                continue
            meter = _Meter()
            try:
                self._ends[topic] = self.robot.listen(topic, meter.arrived)
                self._meters[topic] = meter
            except Error as error:
                self._problems[topic] = str(error)

    def take(self) -> Push | None:
        found: dict[str, Any] = {topic: meter.rates() for topic, meter in self._meters.items()}
        found.update({topic: {"problem": text} for topic, text in self._problems.items()})
        return Push(found) if found else None

    def close(self) -> None:
        for topic in list(self._meters):
            self._forget(topic)

    def _forget(self, topic: str) -> None:
        self._ends.pop(topic)()
        del self._meters[topic]


class _Meter:
    def __init__(self) -> None:
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=_MOST_TIMES)

    def arrived(self, arrival: Arrival) -> None:
        self._arrivals.append((arrival.at, len(arrival.raw._buff)))

    def rates(self) -> dict[str, float]:
        now = monotonic()
        recent = [each for each in list(self._arrivals) if each[0] > now - _WINDOW]
        if len(recent) < 2 or recent[-1][0] <= recent[0][0]:
            return {"hz": len(recent) / _WINDOW, "bytes": sum(size for _, size in recent) / _WINDOW}
        hz = (len(recent) - 1) / (recent[-1][0] - recent[0][0])
        return {"hz": hz, "bytes": hz * sum(size for _, size in recent) / len(recent)}
