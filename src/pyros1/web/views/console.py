"""Shows the log messages from all nodes as they arrive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import Push
from pyros1.web.views.view import View, number_arg, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_ENTRIES, _MAX_CHARACTERS = 2_000, 1_000_000
"""Maximum number of messages per push, and maximum total number of their characters."""


class ConsoleView(View):
    """The log messages that the page does not have yet.

    Args (sent by the page):
        after: number of the last message that the page has; 0 if it has none.
        run: id of the run of the server in which this number was assigned. If the server has been restarted since, all
            stored messages are sent.

    Pushes ``{"run": RUN, "dropped": N, "entries": [[number, time, level, node, text, file, function, line, topics,
    nanoseconds], ...]}``.
    """

    period = 1 / 15

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        robot.check_visible("/rosout")
        is_same_run = string_arg(args, "run", robot.console.run_id) == robot.console.run_id
        self._last_number = int(number_arg(args, "after", 0, 1 << 53, 0)) if is_same_run else 0
        self._unsubscribe = robot.console.listen(wake)
        wake()

    def poll(self) -> Push | None:
        entries, dropped = self.robot.console.entries_after(self._last_number, _MAX_ENTRIES, _MAX_CHARACTERS)
        if not entries:
            return None
        self._last_number = entries[-1].number
        self.wake()  # there may be more messages
        access = self.robot.access
        if access.topics:  # each log message lists the topics of its node
            entries = [entry._replace(topics=access.visible_names(entry.topics)) for entry in entries]
        return Push({"run": self.robot.console.run_id, "dropped": dropped, "entries": entries})

    def close(self) -> None:
        self._unsubscribe()
