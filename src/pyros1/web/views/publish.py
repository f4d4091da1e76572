"""Publishes a message repeatedly while a page displays this view."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.models.repeated_publisher import RepeatedPublisher
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, number_arg, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MIN_RATE, _MAX_RATE = 0.01, 1000.0


class PublishView(View):
    """Publishes a message at a given rate while the view is open; the page may change the message and the rate.

    Args (sent by the page):
        topic, type: the names of the topic and of its message type.
        value: the message as JSON; see `pyros1.msgs.json_form`.
        latch: whether later subscribers also receive the last message.
        hz: messages per second.

    Pushes ``{"sent": N, "subscribers": N, "problem": TEXT}``.
    """

    period = 0.2
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        if robot.access.read_only:
            raise RequestError("this server is read-only (--read-only)")
        _ = robot.node
        self._last_pushed: Any = None
        self._publisher = RepeatedPublisher(*self._read_args(args))

    def change(self, args: Mapping[str, Any]) -> None:
        self._publisher.change(*self._read_args(args))

    def poll(self) -> Push | None:
        publisher = self._publisher
        status = {"sent": publisher.sent, "subscribers": publisher.subscribers, "problem": publisher.problem}
        if status == self._last_pushed:
            return None
        self._last_pushed = status
        return Push(status)

    def close(self) -> None:
        self._publisher.close()

    def _read_args(self, args: Mapping[str, Any]) -> tuple[Callable[[], int], float]:
        topic, type_name = string_arg(args, "topic"), string_arg(args, "type")
        self.robot.check_visible(topic)
        value, latch = args.get("value"), bool(args.get("latch"))
        publishers = self.robot.publishers
        return lambda: publishers.publish(topic, type_name, value, latch), number_arg(
            args, "hz", _MIN_RATE, _MAX_RATE, 1.0
        )
