"""Shows an action's goals, as they change (https://wiki.ros.org/actionlib)."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, MessageError
from pyros1.web.hub import Arrival
from pyros1.web.models.goals import Goals
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.message import tree
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_GOALS_WITH_DETAILS = 10
"""Maximum number of goals whose feedback and result are displayed."""


class ActionView(View):
    """The goals that have been sent to an action's server.

    Args (sent by the page):
        action: the action's name, which is the prefix of its topics.

    Pushes ``{"goals": [{"id", "stamp", "status", "text", "feedbacks", "feedback": tree, "result": tree}, ...]}``,
    newest first; a tree is described at `pyros1.web.views.message.MessageView`.
    """

    period = 1 / 10

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        name = string_arg(args, "action")
        self._lock = threading.Lock()
        self._goals = Goals()
        self._problem = ""
        self._unsubscribers: list[Callable[[], None]] = []
        handlers = {
            "status": self._goals.add_statuses,
            "feedback": self._goals.add_feedback,
            "result": self._goals.add_result,
        }
        try:
            for suffix, handler in handlers.items():
                self._unsubscribers.append(robot.listen(f"{name}/{suffix}", self._make_listener(handler)))
        except Error:
            self.close()
            raise

    def poll(self) -> Push | None:
        with self._lock:
            if self._problem:
                raise RequestError(self._problem)
            goals = [
                {
                    "id": goal.id,
                    "stamp": goal.stamp,
                    "status": goal.status,
                    "text": goal.text,
                    "feedbacks": goal.num_feedbacks,
                    "feedback": tree(goal.feedback)
                    if goal.feedback is not None and index < _MAX_GOALS_WITH_DETAILS
                    else None,
                    "result": tree(goal.result)
                    if goal.result is not None and index < _MAX_GOALS_WITH_DETAILS
                    else None,
                }
                for index, goal in enumerate(self._goals.all())
            ]
        return Push({"goals": goals})

    def close(self) -> None:
        for unsubscribe in self._unsubscribers:
            unsubscribe()

    def _make_listener(self, handler: Callable[[Any], None]) -> Callable[[Arrival], None]:
        def on_message(arrival: Arrival) -> None:
            try:
                message = arrival.message
                with self._lock:
                    handler(message)
                    self._problem = ""
            except MessageError as error:
                self._problem = str(error)
            except (AttributeError, TypeError) as error:  # the topics do not have the types of an action's topics
                self._problem = f"this is not an action: {error}"
            self.wake()

        return on_message
