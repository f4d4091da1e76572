"""Shows running launches, and the states of their processes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.doctor.concurrent import run_concurrently
from pyros1.ground.errors import Error
from pyros1.launch.running.control import Launch, Report, launch_uris
from pyros1.net.hosts import parse_uri
from pyros1.web.models.launches import CpuSample, cpu_times, describe
from pyros1.web.server.wire import Push
from pyros1.web.views.view import View

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MIN_PERIOD = 1.0
_TIMEOUT = 2.0
_MAX_LAUNCHES = 50
_RETRY_DELAY = 10.0
"""Seconds for which a launch that did not respond is not queried again, so that it does not delay the others."""
_MAX_POLL_FRACTION = 0.1
"""Maximum share of time spent on requests: if there are many processes, launches are queried less often."""


class LaunchesView(View):
    """Pushes ``{"launches": [{"param", "uri", "host", "problem", ...}], "more": N}``.

    Each launch has the fields returned by `pyros1.web.models.launches.describe`, or a problem if it does not respond.
    """

    period = _MIN_PERIOD
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._launches: dict[str, Launch] = {}
        self._unreachable: dict[str, tuple[float, str]] = {}
        self._cpu_times: dict[str, dict[tuple[str, int], CpuSample]] = {}

    def poll(self) -> Push | None:
        start = monotonic()
        params = launch_uris(self.robot.master)
        selected = dict(sorted(params.items())[:_MAX_LAUNCHES])
        self._forget({*selected.values()})
        entries = [
            self._describe_launch(param, uri, reply) for (param, uri), reply in self._query_launches(selected).items()
        ]
        self.period = (
            max(_MIN_PERIOD, (monotonic() - start) / _MAX_POLL_FRACTION) if not self._unreachable else _MIN_PERIOD
        )
        return Push({"launches": entries, "more": len(params) - len(selected)})

    def change(self, args: Mapping[str, Any]) -> None:
        """Query all launches at once, including those that did not respond, since the page has changed something."""
        self._unreachable.clear()

    def close(self) -> None:
        self._forget(set())

    def _forget(self, current: set[str]) -> None:
        for uri in self._launches.keys() - current:
            self._launches.pop(uri).close()
            self._cpu_times.pop(uri, None)
        self._unreachable = {uri: failure for uri, failure in self._unreachable.items() if uri in current}

    def _query_launches(self, params: Mapping[str, str]) -> dict[tuple[str, str], Report | Exception | str]:
        now = monotonic()
        replies: dict[tuple[str, str], Report | Exception | str] = {}
        jobs = {}
        for param_and_uri in params.items():
            retry_at, problem = self._unreachable.get(param_and_uri[1], (0.0, ""))
            replies[param_and_uri] = problem
            if now >= retry_at:
                jobs[param_and_uri] = partial(self._request_report, param_and_uri[1])
        for param_and_uri, reply in run_concurrently(jobs, _TIMEOUT + 1).items():
            replies[param_and_uri] = reply
            if isinstance(reply, Exception):
                self._unreachable[param_and_uri[1]] = (now + _RETRY_DELAY, str(reply))
            else:
                self._unreachable.pop(param_and_uri[1], None)
        return replies

    def _request_report(self, uri: str) -> Report:
        launch = self._launches.get(uri)
        if launch is None:
            launch = self._launches[uri] = Launch(uri, _TIMEOUT)
        return launch.report()

    def _describe_launch(self, param: str, uri: str, reply: Report | Exception | str) -> dict[str, Any]:
        entry: dict[str, Any] = {"param": param, "uri": uri[:1000], "host": _host(uri)}
        if not isinstance(reply, Report):
            return {**entry, "problem": str(reply)}
        now = monotonic()
        entry.update(describe(reply, now, self._cpu_times.get(uri, {})))
        self._cpu_times[uri] = cpu_times(reply, now)
        return entry


def _host(uri: str) -> str:
    try:
        return parse_uri(uri)[0]
    except Error:
        return ""
