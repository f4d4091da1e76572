"""Shows the newest message on a topic as a tree, with the topic's rate and the message's size."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import TVal
from pyros1.msgs import Message
from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.transforms.rates import Meter
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_ELEMENTS = 64
"""Maximum number of elements displayed per array."""
_MAX_TEXT_LENGTH = 2_000
_MAX_VALUES = 5_000
"""Maximum number of values displayed per message."""
_MAX_WINDOWS = 100


class MessageView(View):
    """The newest message on a topic.

    Args (sent by the page):
        topic: the topic's full name.
        windows: path of a long array -> index of the first element to display, such as ``{"ranges": 64}``.
        frozen: whether to keep displaying the current message.

    Pushes ``{"type", "count", "hz", "bytes", "size", "time", "age", "publisher", "latched", "value": tree}``.
    The message arrived at "time", "age" seconds ago. In a tree, a message is ``{"fields": [[name, type, value],
    ...]}``, an array is ``{"length": N, "start": N, "items": [...]}``, and a time is ``{"secs": S, "nsecs": N}``.
    ``more`` marks a message whose fields have been omitted.
    """

    period = 1 / 20

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._lock = threading.Lock()
        self._newest: Arrival | None = None
        self._last_pushed: Arrival | None = None
        self._count = 0
        self._meter = Meter(monotonic())
        self._windows: dict[str, int] = {}
        self._frozen = self._needs_redraw = False
        self._topic = string_arg(args, "topic")
        self.change(args)
        self._unsubscribe = robot.listen(self._topic, self._on_message)

    def change(self, args: Mapping[str, Any]) -> None:
        if string_arg(args, "topic") != self._topic:
            raise RequestError("the topic of a stream cannot be changed")
        self._windows = _parse_windows(args.get("windows", {}))
        self._frozen = bool(args.get("frozen"))
        self._needs_redraw = True

    def _on_message(self, arrival: Arrival) -> None:
        with self._lock:
            self._newest = arrival
            self._count += 1
        self._meter.add(arrival.arrived_at, len(arrival.raw._buff))
        self.wake()

    def poll(self) -> Push | None:
        with self._lock:
            arrival, count = self._newest, self._count
        if self._frozen and self._last_pushed is not None:
            arrival = self._last_pushed
        if arrival is None or (arrival is self._last_pushed and not self._needs_redraw):
            return None
        self._last_pushed, self._needs_redraw = arrival, False
        header = arrival.raw._connection_header or {}
        rate = self._meter.rate(monotonic())
        size = len(arrival.raw._buff)
        description = {
            "type": header.get("type", ""),
            "publisher": header.get("callerid", ""),
            "count": count,
            "hz": rate and rate.hz,
            "bytes": rate and rate.bytes,
            "size": size,
            "time": arrival.time,
            "age": monotonic() - arrival.arrived_at,
            "latched": header.get("latching") == "1",
        }
        try:
            value = tree(arrival.message, self._windows)
        except MessageError as error:
            return Push({**description, "value": None, "problem": str(error)})
        return Push({**description, "value": value})

    def close(self) -> None:
        self._unsubscribe()


def _parse_windows(value: Any) -> dict[str, int]:
    if not isinstance(value, dict) or len(value) > _MAX_WINDOWS:
        raise RequestError(f"windows must be an object with at most {_MAX_WINDOWS} paths")
    for start in value.values():
        if isinstance(start, bool) or not isinstance(start, int) or not 0 <= start < 1 << 32:
            raise RequestError("a window must begin at the index of an element")
    return value


def tree(message: Message, windows: Mapping[str, int] | None = None) -> Any:
    """Return a message as a tree of JSON for display, with long arrays and strings cut off; see `MessageView`.

    Args:
        message: the message.
        windows: path of an array, such as ``poses[3].covariance`` -> index of the first element to display.
    """
    remaining_values = _MAX_VALUES
    windows = windows or {}

    def fields(value: Message, path: str) -> dict[str, Any]:
        slots = zip(value.__slots__, value._slot_types, strict=True)
        prefix = path and f"{path}."
        return {
            "fields": [
                [name, field_type, element(getattr(value, name), field_type, prefix + name)]
                for name, field_type in slots
            ]
        }

    def array(value: Any, field_type: str, path: str) -> dict[str, Any]:
        length = len(value)
        start = min(windows.get(path, 0), max(0, length - 1))
        end = min(length, start + max(0, min(_MAX_ELEMENTS, remaining_values)))
        items = [element(value[index], field_type, f"{path}[{index}]") for index in range(start, end)]
        return {"length": length, "start": start, "items": items}

    def element(value: Any, field_type: str, path: str) -> Any:
        nonlocal remaining_values
        remaining_values -= 1
        if isinstance(value, TVal):
            return {"secs": value.secs, "nsecs": value.nsecs}
        if isinstance(value, Message):
            return fields(value, path) if remaining_values > 0 else {"fields": [], "more": True}
        if isinstance(value, float):
            return value if math.isfinite(value) else str(value)
        if isinstance(value, str):
            return value[:_MAX_TEXT_LENGTH] + ("..." if len(value) > _MAX_TEXT_LENGTH else "")
        if isinstance(value, (bool, int)):
            return value if -(1 << 53) < value < 1 << 53 else str(value)
        return array(value, field_type.partition("[")[0], path)

    return fields(message, "")
