"""Serves one page's calls, and its streams, each with at most one push in flight; uses no sockets or clocks."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.errors import Error
from pyros1.web import calls, views
from pyros1.web.robot import Robot
from pyros1.web.server import wire
from pyros1.web.server.wire import RequestError
from pyros1.web.service_calls import ServiceCalls
from pyros1.web.views.view import View

MAX_STREAMS = 200
_RETRY_DELAY = 1.0
"""Seconds after which a failed attempt to create a view is repeated."""


class _Stream:
    """A stream of a view's data to a page.

    Args:
        make_view: creates the view from its arguments; called again after an error, for example if there is no master.
        args: the view's arguments.
    """

    def __init__(self, make_view: Callable[[Mapping[str, Any]], View], args: Mapping[str, Any]) -> None:
        self.make_view = make_view
        self.args = args
        self.lock = threading.Lock()  # guards the view, which may be slow and must not delay other streams
        self.view: View | None = None
        self.is_pushing = False
        self.is_closed = False
        self.is_acknowledged = True  # the page has displayed the last push
        self.has_update = True
        self.pushed_at = float("-inf")
        self.problem = ""

    def due_time(self) -> float | None:
        """Return the monotonic time of the next push.

        The time is None if it is not known yet: there must first be an update, an acknowledgement by the page, or the
        end of the current push.
        """
        if self.is_pushing or self.is_closed:
            return None
        if self.view is None:
            return self.pushed_at + _RETRY_DELAY
        if not self.is_acknowledged or not (self.has_update or self.view.polls_periodically):
            return None
        return self.pushed_at + self.view.period


class Session:
    """A page's streams and calls.

    `take_due_streams` is called in the thread of the server's event loop. `handle`, `push`, `run_call` and `close` may
    block, and run in other threads, concurrently for different streams.

    Args:
        robot: the robot that the page shows.
        wake: called, from any thread, when a stream may be due.
    """

    def __init__(self, robot: Robot, wake: Callable[[], object]) -> None:
        self._robot = robot
        self._wake = wake
        self._streams: dict[int, _Stream] = {}
        self._service_calls = ServiceCalls()

    def take_due_streams(self, now: float) -> tuple[list[int], float | None]:
        """Return the streams for which `push` must be called now, and mark them as being pushed.

        Args:
            now: monotonic time in seconds.

        Returns:
            The numbers of the streams, and the monotonic time at which to call this again. The time is None if no
            stream will be due until `wake` is called.
        """
        numbers: list[int] = []
        next_time: float | None = None
        for number, stream in list(self._streams.items()):
            due = stream.due_time()
            if due is None:
                continue
            if due <= now:
                stream.is_pushing, stream.pushed_at, stream.has_update = True, now, False
                numbers.append(number)
            else:
                next_time = due if next_time is None else min(due, next_time)
        return numbers, next_time

    def push(self, number: int) -> str | bytes | None:
        """Return the next frame for a stream that `take_due_streams` returned; None if its view has nothing new."""
        stream = self._streams.get(number)
        if stream is None:
            return None
        with stream.lock:
            try:
                return self._next_frame(number, stream)
            finally:
                stream.is_pushing = False
                self._wake()

    def handle(self, request: wire.Open | wire.Change | wire.Next | wire.Close) -> list[str]:
        """Handle a request about a stream; return the response's frames."""
        try:
            match request:
                case wire.Open(number, name, args):
                    self._open_stream(number, name, args)
                case wire.Change(number, args):
                    self._change_stream(number, args)
                case wire.Next(number):
                    if (stream := self._streams.get(number)) is not None:
                        stream.is_acknowledged = True
                        self._wake()
                case wire.Close(number):
                    self._close_stream(number)
        except Error as error:
            return [wire.problem(request.stream, str(error))]
        return []

    def run_call(self, call: wire.Call) -> str:
        """Run a call; return the response's frame."""
        try:
            return wire.result(call.id, calls.run(self._robot, call.name, call.args, self._service_calls))
        except Error as error:
            return wire.failure(call.id, str(error))
        except Exception as error:  # noqa: BLE001 - a bug, which the page should report
            return wire.failure(call.id, f"internal server error: {error!r:.500}")

    def close(self) -> None:
        """End all streams and service calls."""
        self._service_calls.close()
        for number in list(self._streams):
            self._close_stream(number)

    def _open_stream(self, number: int, name: str, args: Mapping[str, Any]) -> None:
        if number in self._streams:
            raise RequestError(f"stream {number} is already open")
        if len(self._streams) >= MAX_STREAMS:
            raise RequestError(f"a page can have at most {MAX_STREAMS} streams")
        if name not in views.VIEW_NAMES:
            raise RequestError(f"unknown view {name[:100]!r}")
        view_class = views.view_class(name)

        def on_update() -> None:
            if not stream.has_update:  # otherwise, the pending push will show the newest data
                stream.has_update = True
                self._wake()

        stream = self._streams[number] = _Stream(lambda args: view_class(self._robot, args, on_update), args)
        self._wake()

    def _change_stream(self, number: int, args: Mapping[str, Any]) -> None:
        stream = self._streams.get(number)
        if stream is None:
            return
        with stream.lock:
            stream.args = args
            if stream.view is not None:
                stream.view.change(args)
            stream.has_update, stream.pushed_at, stream.problem = True, float("-inf"), ""
        self._wake()

    def _next_frame(self, number: int, stream: _Stream) -> str | bytes | None:
        if stream.is_closed:
            return None
        try:
            if stream.view is None:
                stream.view = stream.make_view(stream.args)
            push = stream.view.poll()
            frame = None if push is None else wire.push(number, push)
        except Error as error:
            problem = str(error)
        except Exception as error:  # noqa: BLE001 - a bug, which the page should report
            problem = f"internal server error: {error!r:.500}"
        else:
            stream.problem = ""
            stream.is_acknowledged = frame is None
            return frame
        if problem == stream.problem:
            return None
        stream.problem = problem
        return wire.problem(number, problem)

    def _close_stream(self, number: int) -> None:
        stream = self._streams.pop(number, None)
        if stream is None:
            return
        stream.is_closed = True
        with stream.lock:
            if stream.view is not None:
                stream.view.close()
