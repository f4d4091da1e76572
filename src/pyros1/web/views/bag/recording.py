"""The state of the recording."""

from __future__ import annotations

from typing import Any

from pyros1.web.server.wire import Push
from pyros1.web.views.view import View


class BagRecordingView(View):
    """The current recording, or the last one.

    Pushes ``{"recording": STATUS}``; see `pyros1.web.bags.recording.Recording.status`, or null if there was none.
    """

    period = 0.5
    polled = True
    _last_shown: Any = ()

    def poll(self) -> Push | None:
        recording = self.robot.bags.recording
        status = None if recording is None else recording.status()
        if status == self._last_shown:
            return None
        self._last_shown = status
        return Push({"recording": status})
