"""The curves in a plot: each reads values from messages, and queues the points that are to be sent to a page."""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import Error, MessageError
from pyros1.ground.timing import TVal
from pyros1.msgs import Message
from pyros1.observe.expression import Expression, ExpressionError
from pyros1.observe.fields import FieldPath, FieldPathError
from pyros1.web.transforms.decimation import decimate

MAX_PARTS = 50
"""Maximum number of elements of an array that are plotted, each as its own curve."""
MAX_POINTS = 20_000
"""Maximum number of points queued per array element; beyond that, some are removed, but spikes are preserved."""
_EXPRESSION_PATTERN = re.compile(r"\s*(/[\w/]+)\s*:\s*(.+?)\s*\Z", re.DOTALL)

FindTopic = Callable[[str], "tuple[str, str, str] | None"]
"""Splits ``/topic/field`` into topic, type and field path, or returns None; see `pyros1.graph.Graph.find_topic`."""


class CurveError(Error):
    """A curve's text is malformed, or a value cannot be drawn."""


class Curve:
    """A value from a topic's messages, over time.

    Args:
        text: ``/topic/field``, ``/topic`` if its messages have only one field, ``/topic/array[2]``,
            ``/topic/array[0:3]``, or ``/topic: EXPRESSION`` where ``m`` is the message, such as ``/odom:
            hypot(m.twist.twist.linear.x, m.twist.twist.linear.y)``.
        stamped: whether to use the time in each message's header instead of its time of arrival.

    Attributes:
        problem: why the last message has no value to draw; empty if it has one.
        has_data: whether a message has arrived.

    Raises:
        CurveError: the text is malformed.
    """

    def __init__(self, text: str, stamped: bool = False) -> None:
        self.text = text.strip()
        self.problem = ""
        self.has_data = False
        self._stamped = stamped
        self._lock = threading.Lock()
        self._points: dict[int, tuple[list[float], list[float]]] = {}
        self._read_value: Callable[[Any], Any] | None = None
        match = _EXPRESSION_PATTERN.match(text)
        self._expression: Expression | None = None
        self._topic = ""
        if match:
            self._topic = match[1]
            try:
                self._expression = Expression(match[2])
            except ExpressionError as error:
                raise CurveError(str(error)) from None
        elif not self.text.startswith("/"):
            raise CurveError(f"a curve must be /topic/field, not {self.text[:100]!r}")

    def find(self, find_topic: FindTopic) -> str | None:
        """Find the curve's topic and field; return the topic, or None while the master does not list it.

        Raises:
            CurveError: the part after the topic's name is not a field.
        """
        if self._expression is not None:
            topic_type_and_field = find_topic(self._topic)
            self._read_value = self._evaluate
            return topic_type_and_field[0] if topic_type_and_field and not topic_type_and_field[2] else None
        topic_type_and_field = find_topic(self.text)
        if topic_type_and_field is None:
            return None
        try:
            path = FieldPath(topic_type_and_field[2])
        except FieldPathError as error:
            raise CurveError(str(error)) from None
        self._read_value = lambda message: _read_field(path, message)
        return topic_type_and_field[0]

    def add(self, message: Any, arrived_at: float) -> None:
        """Add the point that a message contains, or record why it has none in `problem`."""
        self.has_data = True
        try:
            value = self._read_value(message) if self._read_value else None
            numbers = _to_numbers(value)
        except (CurveError, FieldPathError, ExpressionError, MessageError) as error:
            self.problem = str(error)
            return
        self.problem = ""
        time = arrived_at
        if self._stamped and getattr(message, "_has_header", False):
            time = message.header.stamp.to_sec()
        with self._lock:
            for part, number in numbers:
                times, values = self._points.setdefault(part, ([], []))
                times.append(time)
                values.append(number)
                if len(times) > MAX_POINTS:
                    times[:], values[:] = decimate(times, values, MAX_POINTS // 2)

    def take(self, max_points: int) -> dict[int, tuple[list[float], list[float]]]:
        """Return the points added since the last call, as part -> (times, values).

        A part is the index of an array element, or -1 if the value is a single number.

        Args:
            max_points: maximum number of points per part.
        """
        with self._lock:
            points, self._points = self._points, {}
        return {part: decimate(times, values, max_points) for part, (times, values) in sorted(points.items())}

    def _evaluate(self, message: Any) -> Any:
        return self._expression({"m": message}) if self._expression else None


def _read_field(path: FieldPath, message: Any) -> Any:
    try:
        return path.get(message)[0]
    except FieldPathError as error:
        path.type_in(type(message))  # raises an error that says more if a name is wrong
        raise CurveError(f"the last message has no such element, index out of range: {path.text}") from error


def _to_numbers(value: Any) -> list[tuple[int, float]]:
    if isinstance(value, (list, tuple, bytes)):
        if len(value) > MAX_PARTS:
            raise CurveError(f"an array of {len(value)} elements: choose some, as in [0] or [0:3]")
        return [(part, _to_number(element)) for part, element in enumerate(value)]
    return [(-1, _to_number(value))]


def _to_number(value: Any) -> float:
    if isinstance(value, Message) and len(value.__slots__) == 1:  # such as a std_msgs/Float64
        value = getattr(value, value.__slots__[0])
    if isinstance(value, TVal):
        return float(value.to_sec())
    if not isinstance(value, (int, float)):
        description = "a string" if isinstance(value, str) else "a message: choose one of its fields"
        raise CurveError(f"not a number, but {description}")
    try:
        return float(value)
    except OverflowError:
        return math.inf
