"""Shows the state of the current or last recording."""

from __future__ import annotations

from typing import Any

from pyros1.web.server.wire import Push
from pyros1.web.views.view import View


class BagRecordingView(View):
    """The state of the current or last recording.

    Pushes ``{"recording": STATUS}`` whenever it changes. STATUS is described at
    `pyros1.web.bags.recording.Recording.status`; null stands for no recording so far.
    """

    period = 0.5
    polls_periodically = True
    _last_status: Any = ()

    def poll(self) -> Push | None:
        recording = self.robot.bags.recording
        status = None if recording is None else recording.status()
        if status == self._last_status:
            return None
        self._last_status = status
        return Push({"recording": status})
