"""Measures the rates of topics that no node subscribes to: publishers only send messages if the server subscribes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error
from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.transforms.rates import Meter
from pyros1.web.views.view import View

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MAX_TOPICS = 50


class RatesView(View):
    """The traffic on chosen topics, to which the server subscribes while this view is open.

    Args (sent by the page):
        topics: a list of the topics' full names.

    Pushes ``{TOPIC: {"hz": N, "bytes": N per second} or {"problem": TEXT}}``, with null for numbers that are not known
    yet.
    """

    period = 1.0
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._meters: dict[str, Meter] = {}
        self._unsubscribers: dict[str, Callable[[], None]] = {}
        self._problems: dict[str, str] = {}
        self.change(args)

    def change(self, args: Mapping[str, Any]) -> None:
        topics = args.get("topics", [])
        if (
            not isinstance(topics, list)
            or len(topics) > MAX_TOPICS
            or not all(isinstance(topic, str) for topic in topics)
        ):
            raise RequestError(f"topics must be a list of at most {MAX_TOPICS} names")
        for topic in self._meters.keys() - topics:
            self._forget(topic)
        self._problems = {}
        for topic in topics:
            if topic in self._meters:
                continue
            meter = Meter(monotonic())
            try:
                self._unsubscribers[topic] = self.robot.listen(topic, partial(_count_message, meter))
                self._meters[topic] = meter
            except Error as error:
                self._problems[topic] = str(error)

    def poll(self) -> Push | None:
        rates = {topic: meter.rate(monotonic()) for topic, meter in self._meters.items()}
        traffic: dict[str, Any] = {
            topic: rate._asdict() if rate else {"hz": None, "bytes": None} for topic, rate in rates.items()
        }
        traffic.update({topic: {"problem": text} for topic, text in self._problems.items()})
        return Push(traffic) if traffic else None

    def close(self) -> None:
        for topic in list(self._meters):
            self._forget(topic)

    def _forget(self, topic: str) -> None:
        self._unsubscribers.pop(topic)()
        del self._meters[topic]


def _count_message(meter: Meter, arrival: Arrival) -> None:
    meter.add(arrival.arrived_at, len(arrival.raw._buff))
