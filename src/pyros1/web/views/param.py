"""One parameter that is a long text, such as robot_description, and what others change of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import ParameterNotSetError
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, text

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MOST_TEXT = 16 << 20
"""Most characters that are sent."""
_PERIOD = 1.0
_SHARE = 0.05
"""Most of the time that asking takes: a long text is asked for less often."""


class ParamView(View):
    """A parameter's text.

    Args (of the page):
        param: the parameter's full name.

    Pushes ``{"text": TEXT}``, or ``{"text": null, "why": TEXT}`` for a parameter that is not set or not a text.
    """

    period = _PERIOD
    polled = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._shown: dict[str, Any] | None = None
        self.change(args)

    def take(self) -> Push | None:
        start = monotonic()
        facts = self._look()
        self.period = max(_PERIOD, (monotonic() - start) / _SHARE)
        if facts == self._shown:
            return None
        self._shown = facts
        return Push(facts)

    def change(self, args: Mapping[str, Any]) -> None:
        self._name = text(args, "param")
        self.robot.check_visible(self._name)
        self._shown = None

    def _look(self) -> dict[str, Any]:
        try:
            value = self.robot.parameters.get(self._name)
        except ParameterNotSetError:
            return {"text": None, "why": f"there is no parameter {self._name}"}
        if not isinstance(value, str):
            return {"text": None, "why": f"{self._name} is not a string"}
        if len(value) > MOST_TEXT:
            raise RequestError(f"{self._name} has {len(value)} characters; {MOST_TEXT} can be shown")
        return {"text": value}
