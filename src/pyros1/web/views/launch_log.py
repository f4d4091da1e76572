"""Shows the last lines of a launched process's log files."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.launch.running.logs import log_folder
from pyros1.net.hosts import is_local, parse_uri
from pyros1.web.calls.launches import connect_to_launch
from pyros1.web.models.launches import last_lines, log_files
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot


class LaunchLogView(View):
    """The ends of a process's log files, as they grow.

    Args (sent by the page):
        launch: name of the parameter that the launch has set.
        process: the process's label.

    Pushes ``{"files": [{"path", "size", "text"}, ...], "base": TEXT, "folder": TEXT}`` after each change. The files are
    those of the process in the log folder; ``base`` is their path without suffixes such as ``.log``.
    """

    period = 1.0
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._folder = log_folder(os.environ)
        self._log_base_path = self._find_log_path(args)
        self._last_stamps: object = None

    def _find_log_path(self, args: Mapping[str, Any]) -> str:
        launch = connect_to_launch(self.robot, args)
        label = string_arg(args, "process")
        try:
            entry = next((entry for entry in launch.status() if entry.label == label), None)
        finally:
            launch.close()
        if entry is None:
            raise RequestError(f"this launch has no process {label[:200]}")
        if not entry.log:
            raise RequestError("this process has no log files")
        if entry.machine or not is_local(parse_uri(launch.uri)[0]):
            raise RequestError(f"the log files are on another machine: {entry.log}*.log")
        return entry.log

    def poll(self) -> Push | None:
        try:
            files = log_files(self._log_base_path, self._folder)
            stamps = [(path, path.stat().st_size, path.stat().st_mtime_ns) for path in files]
            if stamps == self._last_stamps:
                return None
            contents = [{"path": str(path), "size": size, "text": last_lines(path)} for path, size, _ in stamps]
        except (OSError, ValueError) as error:  # ValueError: for example, the path contains a null character
            raise RequestError(f"the log files cannot be read: {error}") from None
        self._last_stamps = stamps
        return Push({"files": contents, "base": self._log_base_path, "folder": str(self._folder)})
