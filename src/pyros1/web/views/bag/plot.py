"""Plots recorded numbers over a bag's time."""

from __future__ import annotations

import threading
from array import array
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import untrusted
from pyros1.web.bags.envelope import Envelope
from pyros1.web.bags.open_bag import OpenBag
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.transforms.curves import Curve, CurveError
from pyros1.web.views.bag.file import BagView
from pyros1.web.views.view import number_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MAX_CURVES = 16
MAX_LINES = 64
"""Maximum number of lines in a plot; each element of an array has its own line."""
_NUM_PARTS = 800
"""Number of parts of the time range; in each, up to four points per line are kept."""
_BATCH_MESSAGES = 200
_POLL_PERIOD = 0.3
"""Seconds between pushes of partial results, and between checks of whether to stop waiting."""
_MAX_SECONDS = 4.29e9  # the sum of two such times in nanoseconds fits in 64 bits


class BagPlotView(BagView):
    """Curves of recorded numbers. While a thread reads the bag, partial results are displayed.

    Args (sent by the page):
        path: path of an open bag.
        curves: a list of ``{"id": N, "text": TEXT}``; see `pyros1.web.transforms.curves.Curve`.
        begin, end: the time range, in seconds since the bag's start.

    Pushes ``{"begin", "end", "progress": 0..1, "curves": [{"id", "part", "count"}, ...], "problems": {ID: TEXT}}``,
    each time with all points so far, in the form described at `PlotView`. Progress is 1 when everything has been read.
    """

    period = _POLL_PERIOD

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self._job: _ReadJob | None = None
        super().__init__(robot, args, wake)

    def change(self, args: Mapping[str, Any]) -> None:
        curves = _parse_curves(args)
        begin = number_arg(args, "begin", -_MAX_SECONDS, _MAX_SECONDS, 0.0)
        end = number_arg(args, "end", -_MAX_SECONDS, _MAX_SECONDS, self.bag.length)
        if self._job is not None:
            self._job.stop()
            self._job.join()  # this may take as long as it takes to read a chunk
        self._job = _ReadJob(self.bag, curves, begin, max(end, begin + 1e-6), self.robot.bags.read_slots, self.wake)

    def poll(self) -> Push | None:
        return self._job.poll() if self._job is not None else None

    def close(self) -> None:
        if self._job is not None:
            self._job.stop()
            self._job.join()  # a bag must not be closed while a thread reads it
        super().close()


class _ReadJob:
    """Reads the curves' points from a bag once, in a thread."""

    def __init__(
        self,
        bag: OpenBag,
        curve_texts: dict[int, str],
        begin: float,
        end: float,
        read_slots: threading.BoundedSemaphore,
        wake: Callable[[], object],
    ) -> None:
        self._bag, self._begin, self._end, self._read_slots, self._wake = bag, begin, end, read_slots, wake
        self._problems: dict[int, str] = {}
        self._curves: dict[str, list[tuple[int, Curve]]] = {}
        self._lines: dict[tuple[int, int], Envelope] = {}
        self._progress = 0.0
        self._lock = threading.Lock()
        self._stop_requested = threading.Event()
        self._pushed_progress = -1.0
        for curve_id, curve_text in curve_texts.items():
            try:
                curve = Curve(curve_text)
                topic = curve.find(bag.find_topic)
                if topic is None:
                    raise CurveError("no such topic in this bag")
                self._curves.setdefault(topic, []).append((curve_id, curve))
            except Error as error:
                self._problems[curve_id] = str(error)
        self._thread = threading.Thread(target=self._run, name="web: read bag", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Request the thread to stop."""
        self._stop_requested.set()

    def join(self) -> None:
        """Wait for the thread to end after its current chunk."""
        self._thread.join()

    def poll(self) -> Push | None:
        with self._lock:
            if self._progress == self._pushed_progress:
                return None
            self._pushed_progress = self._progress
            lines = {key: line.points() for key, line in sorted(self._lines.items())}
            problems = dict(self._problems)
        entries, blob = [], array("d")
        for (curve_id, part), (times, values) in lines.items():
            entries.append({"id": curve_id, "part": part, "count": len(times)})
            blob.extend(times)
            blob.extend(values)
        data = {
            "begin": self._begin,
            "end": self._end,
            "progress": self._pushed_progress,
            "curves": entries,
            "problems": {curve_id: untrusted(problem) for curve_id, problem in problems.items()},
        }
        return Push(data, blob.tobytes())

    def _run(self) -> None:
        while not self._read_slots.acquire(timeout=_POLL_PERIOD):
            if self._stop_requested.is_set():
                return
        try:
            if self._curves:
                self._read_messages()
        except (Error, OSError) as error:
            with self._lock:
                self._problems.update(
                    dict.fromkeys((curve_id for curves in self._curves.values() for curve_id, _ in curves), str(error))
                )
        finally:
            self._read_slots.release()
        with self._lock:
            self._progress = 1.0
        self._wake()

    def _read_messages(self) -> None:
        bag, reader = self._bag, self._bag.bag.reader
        first, last = bag.nanoseconds(self._begin), bag.nanoseconds(self._end)
        span = max(1, min(last, bag.end) - max(first, bag.begin))
        messages = reader.messages(reader.connection_ids(list(self._curves)), max(0, first), last)
        for count, stored_message in enumerate(messages, 1):
            if self._stop_requested.is_set():
                return
            message = bag.bag.decode(stored_message)
            for _, curve in self._curves.get(stored_message.connection.topic, ()):
                curve.add(message, bag.seconds(stored_message.time))
            if count % _BATCH_MESSAGES == 0:
                self._collect_points()
                with self._lock:
                    self._progress = min(0.999, (stored_message.time - max(first, bag.begin)) / span)
                self._wake()
        self._collect_points()

    def _collect_points(self) -> None:
        with self._lock:
            for curve_id, curve in (pair for curves in self._curves.values() for pair in curves):
                for part, (times, values) in curve.take(_BATCH_MESSAGES).items():
                    line = self._get_line(curve_id, part)
                    if line is None:
                        curve.problem = f"more than {MAX_LINES} lines: choose some elements, as in [0:3]"
                        break
                    for time, value in zip(times, values, strict=True):
                        line.add(time, value)
                if curve.problem:
                    self._problems[curve_id] = curve.problem

    def _get_line(self, curve_id: int, part: int) -> Envelope | None:
        line = self._lines.get((curve_id, part))
        if line is None and len(self._lines) < MAX_LINES:
            line = self._lines[curve_id, part] = Envelope(self._begin, self._end, _NUM_PARTS)
        return line


def _parse_curves(args: Mapping[str, Any]) -> dict[int, str]:
    text_by_id: dict[int, str] = {}
    curves = args.get("curves", [])
    if not isinstance(curves, list) or len(curves) > MAX_CURVES:
        raise RequestError(f"curves must be a list of at most {MAX_CURVES} curves")
    for entry in curves:
        match entry:
            case {"id": int(curve_id), "text": str(curve_text)} if not isinstance(curve_id, bool):
                text_by_id[curve_id] = curve_text[:1_000]
            case _:
                raise RequestError("a curve must have an id and a text")
    return text_by_id
