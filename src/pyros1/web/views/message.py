"""The newest message of a topic, as a tree, with its rate and size."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import TVal
from pyros1.msgs import Message
from pyros1.web.hub import Arrival
from pyros1.web.views.view import View, text
from pyros1.web.wire import Push

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MOST_ELEMENTS = 64
"""Most elements of an array that are shown."""
_MOST_TEXT = 2_000
_MOST_VALUES = 5_000
"""Most values of a message that are shown."""
_WINDOW = 5.0
"""Seconds over which the rate is measured."""
_MOST_TIMES = 10_000


class MessageView(View):
    """A topic's messages.

    Args (of the page):
        topic: the topic's full name.

    Pushes ``{"type", "count", "hz", "bytes", "size", "time", "publisher", "value": tree}``. In a tree, a message is
    ``{"fields": [[name, type, value], ...]}``, an array ``{"length": N, "items": [...]}``, a time
    ``{"secs": S, "nsecs": N}``; what is left out is null with ``more``.
    """

    period = 1 / 20

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._lock = threading.Lock()
        self._newest: Arrival | None = None
        self._shown: Arrival | None = None
        self._count = 0
        self._times: deque[tuple[float, int]] = deque(maxlen=_MOST_TIMES)
        self._end = robot.listen(text(args, "topic"), self._arrived)

    def _arrived(self, arrival: Arrival) -> None:
        with self._lock:
            self._newest = arrival
            self._count += 1
            self._times.append((arrival.at, len(arrival.raw._buff)))
        self.wake()

    def take(self) -> Push | None:
        with self._lock:
            arrival, count = self._newest, self._count
            times = [each for each in self._times if each[0] > monotonic() - _WINDOW]
        if arrival is None or arrival is self._shown:
            return None
        self._shown = arrival
        header = arrival.raw._connection_header or {}
        rate = (
            (len(times) - 1) / (times[-1][0] - times[0][0]) if len(times) > 1 and times[-1][0] > times[0][0] else None
        )
        size = len(arrival.raw._buff)
        facts = {
            "type": header.get("type", ""),
            "publisher": header.get("callerid", ""),
            "count": count,
            "hz": rate,
            "bytes": rate and rate * sum(each for _, each in times) / len(times),
            "size": size,
            "time": arrival.time,
        }
        try:
            value = tree(arrival.message)
        except MessageError as error:
            return Push({**facts, "value": None, "problem": str(error)})
        return Push({**facts, "value": value})

    def close(self) -> None:
        self._end()


def tree(message: Message) -> Any:
    """Return a message as a JSON value for reading: long arrays and texts are cut; see `MessageView`."""
    left = _MOST_VALUES

    def fields(value: Message) -> dict[str, Any]:
        slots = zip(value.__slots__, value._slot_types, strict=True)
        return {"fields": [[name, kind, one(getattr(value, name), kind)] for name, kind in slots]}

    def one(value: Any, kind: str) -> Any:
        nonlocal left
        left -= 1
        if isinstance(value, TVal):
            return {"secs": value.secs, "nsecs": value.nsecs}
        if isinstance(value, Message):
            return fields(value) if left > 0 else {"fields": [], "more": True}
        if isinstance(value, float):
            return value if math.isfinite(value) else str(value)
        if isinstance(value, str):
            return value[:_MOST_TEXT] + ("..." if len(value) > _MOST_TEXT else "")
        if isinstance(value, (bool, int)):
            return value if -(1 << 53) < value < 1 << 53 else str(value)
        length = len(value)
        shown = max(0, min(length, _MOST_ELEMENTS, left))
        base = kind.partition("[")[0]
        return {"length": length, "items": [one(each, base) for each in value[:shown]]}

    return fields(message)
