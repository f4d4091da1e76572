"""A message that is published at a rate while the page displays it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.models.repeated_publisher import RepeatedPublisher
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, number, text

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MIN_RATE, _MAX_RATE = 0.01, 1000.0


class PublishView(View):
    """Publishes while it is open; `change` changes the message and the rate.

    Args (of the page):
        topic, type: their names. value: the message as JSON, see `pyros1.msgs.json_form`.
        latch: whether later subscribers get the last one. hz: messages per second.

    Pushes ``{"sent": N, "subscribers": N, "problem": TEXT}``.
    """

    period = 0.2
    polled = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        if robot.access.read_only:
            raise RequestError("this server is read-only (--read-only)")
        _ = robot.node
        self._last_shown: Any = None
        self._publisher = RepeatedPublisher(*self._read(args))

    def change(self, args: Mapping[str, Any]) -> None:
        self._publisher.change(*self._read(args))

    def poll(self) -> Push | None:
        now = self._publisher
        facts = {"sent": now.sent, "subscribers": now.subscribers, "problem": now.problem}
        if facts == self._last_shown:
            return None
        self._last_shown = facts
        return Push(facts)

    def close(self) -> None:
        self._publisher.close()

    def _read(self, args: Mapping[str, Any]) -> tuple[Callable[[], int], float]:
        topic, kind = text(args, "topic"), text(args, "type")
        self.robot.check_visible(topic)
        value, latch = args.get("value"), bool(args.get("latch"))
        publishing = self.robot.publishing
        return lambda: publishing.publish(topic, kind, value, latch), number(args, "hz", _MIN_RATE, _MAX_RATE, 1.0)
