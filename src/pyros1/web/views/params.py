"""Shows all parameters, and follows their changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.web.models.params import Changes
from pyros1.web.server.wire import Push
from pyros1.web.views.view import View

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MIN_PERIOD = 1.5
_MAX_POLL_FRACTION = 0.05
"""Maximum share of time spent on checks: if there are many parameters, they are checked less often."""


class ParamsView(View):
    """Pushes the result of `pyros1.web.models.params.Changes.update` whenever something has changed."""

    period = _MIN_PERIOD
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._changes = Changes()

    def poll(self) -> Push | None:
        started_at = monotonic()
        changed = self._changes.update(self.robot.master.get_param("/"), self.robot.access.may_see)
        self.period = max(_MIN_PERIOD, (monotonic() - started_at) / _MAX_POLL_FRACTION)
        return None if changed is None else Push(changed)

    def change(self, args: Mapping[str, Any]) -> None:
        """Accept the page's notice that it has changed something: the session then polls immediately."""
