"""Publishes the state of a gamepad that a page reads in its browser."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error
from pyros1.web.models.gamepad import GamepadState, RemoteGamepad, read_state
from pyros1.web.models.repeated_publisher import RepeatedPublisher
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, number_arg, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_JOY_TYPE = "sensor_msgs/Joy"
_MIN_RATE, _MAX_RATE = 5.0, 100.0
_MAX_FRAME_LENGTH = 200


class GamepadView(View):
    """Publishes what a page reads from a gamepad as sensor_msgs/Joy, like joy_node (https://wiki.ros.org/joy).

    A new state is published at once; the last one is repeated until the page releases the gamepad, is silent for
    `pyros1.web.models.gamepad.SILENCE` seconds, closes the view, or loses its connection. Then one message with all
    axes and buttons at 0 is published. Only one view may publish on a topic at a time: with two, the robot would follow
    both pages in turn.

    Args (sent by the page):
        topic, frame_id: the topic's name, and the frame of the messages; read when the view is opened.
        hz: rate in Hz at which an unchanged state is published.
        state: see `pyros1.web.models.gamepad.read_state`; the page changes or repeats this argument after it has
            opened the view.

    Pushes ``{"topic": NAME, "sent": N, "subscribers": N, "problem": TEXT}``.
    """

    period = 0.2
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        if robot.access.read_only:
            raise RequestError("this server is read-only (--read-only)")
        self._topic = robot.full_name(string_arg(args, "topic"))
        robot.check_visible(self._topic)
        self._frame_id = string_arg(args, "frame_id", "")[:_MAX_FRAME_LENGTH]
        self._gamepad = RemoteGamepad()
        self._sent = self._subscribers = 0
        self._last_pushed: Any = None
        # Ignore the state in the first request, which may be outdated by now; the page repeats it.
        _, rate = self._read_args(args)
        if robot.gamepads.setdefault(self._topic, self) is not self:
            raise RequestError(f"another page is already publishing {self._topic}")
        try:
            robot.publishers.advertise(self._topic, _JOY_TYPE)
        except BaseException:
            del robot.gamepads[self._topic]
            raise
        self._publisher = RepeatedPublisher(self._publish_due, rate)

    def change(self, args: Mapping[str, Any]) -> None:
        state, rate = self._read_args(args)
        if self._gamepad.receive(state, monotonic()) or rate != self._publisher.hz:
            self._publisher.change(self._publish_due, rate)

    def poll(self) -> Push | None:
        numbers = {"sent": self._sent, "subscribers": self._subscribers}
        status = {"topic": self._topic, **numbers, "problem": self._publisher.problem}
        if status == self._last_pushed:
            return None
        self._last_pushed = status
        return Push(status)

    def close(self) -> None:
        self._publisher.close()
        self._gamepad.receive(None, monotonic())
        with suppress(Error):  # the master or the node is gone, and with it the publisher
            self._publish_due()
        if self.robot.gamepads.get(self._topic) is self:
            del self.robot.gamepads[self._topic]

    def _read_args(self, args: Mapping[str, Any]) -> tuple[GamepadState | None, float]:
        return read_state(args.get("state")), number_arg(args, "hz", _MIN_RATE, _MAX_RATE, 20.0)

    def _publish_due(self) -> int:
        # Advertise again, in case the publisher was closed. This may wait seconds for subscribers, so the state is read
        # afterwards.
        self.robot.publishers.advertise(self._topic, _JOY_TYPE)
        state = self._gamepad.take(monotonic())
        if state is not None:
            header = {"stamp": "now", "frame_id": self._frame_id}
            value = {"header": header, "axes": state.axes, "buttons": state.buttons}
            self._subscribers = self.robot.publishers.publish(self._topic, _JOY_TYPE, value)
            self._sent += 1
        return self._subscribers
