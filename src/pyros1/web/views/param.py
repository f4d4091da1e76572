"""Shows one parameter with a long string, such as robot_description, and follows its changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import ParameterNotSetError
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MAX_TEXT_LENGTH = 16 << 20
"""Maximum number of characters sent to a page."""
_MIN_PERIOD = 1.0
_MAX_POLL_FRACTION = 0.05
"""Maximum share of time spent on requests: long strings, which take long, are requested less often."""


class ParamView(View):
    """The value of a parameter that is a string.

    Args (sent by the page):
        param: the parameter's full name.

    Pushes ``{"text": TEXT}``, or ``{"text": null, "why": TEXT}`` for a parameter that is not set or not a string.
    """

    period = _MIN_PERIOD
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._last_pushed: dict[str, Any] | None = None
        self.change(args)

    def poll(self) -> Push | None:
        started_at = monotonic()
        data = self._refresh()
        self.period = max(_MIN_PERIOD, (monotonic() - started_at) / _MAX_POLL_FRACTION)
        if data == self._last_pushed:
            return None
        self._last_pushed = data
        return Push(data)

    def change(self, args: Mapping[str, Any]) -> None:
        self._name = string_arg(args, "param")
        self.robot.check_visible(self._name)
        self._last_pushed = None

    def _refresh(self) -> dict[str, Any]:
        try:
            value = self.robot.parameters.get(self._name)
        except ParameterNotSetError:
            return {"text": None, "why": f"there is no parameter {self._name}"}
        if not isinstance(value, str):
            return {"text": None, "why": f"{self._name} is not a string"}
        if len(value) > MAX_TEXT_LENGTH:
            raise RequestError(f"{self._name} has {len(value)} characters; the limit is {MAX_TEXT_LENGTH}")
        return {"text": value}
