"""Plots numbers from messages over time."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, MessageError
from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.transforms.curves import Curve, CurveError
from pyros1.web.views.view import View

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

MAX_CURVES = 200
_MAX_POINTS = 400
"""Maximum number of points per curve and push: 12,000 points per second at 30 pushes per second."""
_POLLS_PER_REFRESH = 30
"""Number of polls after which missing topics are looked up again: about once a second."""


class PlotView(View):
    """The curves of a plot.

    Args (sent by the page):
        curves: a list of ``{"id": N, "text": TEXT, "stamped": bool}``; see `pyros1.web.transforms.curves.Curve`.

    Pushes ``{"now": TIME, "curves": [{"id", "part", "count"}, ...], "problems": {ID: TEXT}, "waiting": {ID: TEXT}}``
    with the points of each entry in "curves" as float64: all times, and then all values. A part is the index of an
    array element, or -1 if the value is a single number. "waiting" says what a curve without problems is waiting for:
    its topic or a message.
    """

    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._curves: dict[int, Curve] = {}
        self._texts: dict[int, tuple[str, bool]] = {}
        self._unsubscribers: dict[int, Callable[[], None]] = {}
        self._problems: dict[int, str] = {}
        self._last_pushed: tuple[dict[int, str], dict[int, str]] = ({}, {})
        self._poll_count = 0
        self.change(args)

    def change(self, args: Mapping[str, Any]) -> None:
        requested = _parse_curves(args)
        for curve_id in [
            known_id
            for known_id, text_and_stamped in self._texts.items()
            if requested.get(known_id) != text_and_stamped
        ]:
            self._forget(curve_id)
        for curve_id, (text, stamped) in requested.items():
            if curve_id in self._texts:
                continue
            self._texts[curve_id] = (text, stamped)
            try:
                self._curves[curve_id] = Curve(text, stamped)
            except CurveError as error:
                self._problems[curve_id] = str(error)
        self._poll_count = 0

    def poll(self) -> Push | None:
        if self._poll_count % _POLLS_PER_REFRESH == 0:
            self._refresh()
        self._poll_count += 1
        entries, blob = [], array("d")
        for curve_id, curve in self._curves.items():
            for part, (times, values) in curve.take(_MAX_POINTS).items():
                entries.append({"id": curve_id, "part": part, "count": len(times)})
                blob.extend(times)
                blob.extend(values)
        problems = {
            **self._problems,
            **{curve_id: curve.problem for curve_id, curve in self._curves.items() if curve.problem},
        }
        waiting = {
            curve_id: self._waiting_reason(curve_id)
            for curve_id, curve in self._curves.items()
            if curve_id not in problems and not curve.has_data
        }
        current = (problems, waiting)
        if not entries and current == self._last_pushed:
            return None
        self._last_pushed = current
        now = self.robot.node.now().to_sec()
        return Push({"now": now, "curves": entries, "problems": problems, "waiting": waiting}, blob.tobytes())

    def close(self) -> None:
        for curve_id in list(self._texts):
            self._forget(curve_id)

    def _forget(self, curve_id: int) -> None:
        self._texts.pop(curve_id)
        self._curves.pop(curve_id, None)
        self._problems.pop(curve_id, None)
        self._unsubscribers.pop(curve_id, lambda: None)()

    def _refresh(self) -> None:
        for curve_id, curve in self._curves.items():
            if curve_id in self._unsubscribers:
                continue
            try:
                topic = curve.find(self.robot.graph.find_topic)
                if topic is not None:
                    self._unsubscribers[curve_id] = self.robot.listen(topic, _CurveListener(curve))
                self._problems.pop(curve_id, None)
            except Error as error:
                self._problems[curve_id] = str(error)

    def _waiting_reason(self, curve_id: int) -> str:
        return "no message yet" if curve_id in self._unsubscribers else "no such topic yet"


class _CurveListener:
    def __init__(self, curve: Curve) -> None:
        self._curve = curve

    def __call__(self, arrival: Arrival) -> None:
        try:
            message = arrival.message
        except MessageError as error:
            self._curve.problem = str(error)
            return
        self._curve.add(message, arrival.time)


def _parse_curves(args: Mapping[str, Any]) -> dict[int, tuple[str, bool]]:
    requested: dict[int, tuple[str, bool]] = {}
    curves = args.get("curves", [])
    if not isinstance(curves, list) or len(curves) > MAX_CURVES:
        raise RequestError(f"curves must be a list of at most {MAX_CURVES} curves")
    for entry in curves:
        match entry:
            case {"id": int(curve_id), "text": str(text)} if not isinstance(curve_id, bool):
                requested[curve_id] = (text, bool(entry.get("stamped")))
            case _:
                raise RequestError("a curve must have an id and a text")
    return requested
