"""``topic plot``: plots numbers in the terminal. Fields are named as in rqt_plot (L209)."""

from __future__ import annotations

import contextlib
import shutil
import sys
from collections import deque
from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.chart import render_chart
from pyros1.cli.shared.curves import expand_messages, parse_curves
from pyros1.cli.shared.printing import should_use_colour
from pyros1.cli.shared.subscribing import subscribe, wait_for_topic
from pyros1.ground.errors import MessageError
from pyros1.ground.timing import TVal
from pyros1.msgs import AnyMsg, Message
from pyros1.observe.decoder import Decoder
from pyros1.observe.expression import Expression, ExpressionError
from pyros1.observe.fields import FieldPath, FieldPathError, split_expression

_MAX_POINTS = 20_000
_REFRESH_PERIOD = 0.1
_CLEAR_SCREEN, _ENTER_ALTERNATE_SCREEN, _LEAVE_ALTERNATE_SCREEN = (
    "\033[H\033[J",
    "\033[?1049h\033[?25l",
    "\033[?25h\033[?1049l",
)


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Draw numeric fields as curves over time."""
    if not args:
        raise UsageError("a topic with a field must be specified")
    if not options.period > 0:
        raise UsageError("the period must be greater than zero")
    curve_names = expand_messages(
        invocation, [curve_name for arg in args for curve_name in parse_curves(invocation, arg)]
    )
    try:
        expression_readers = {curve_name: _expression_reader(curve_name) for curve_name in curve_names}
    except ExpressionError as error:
        raise UsageError(str(error)) from None
    draws_once = bool(options.once) or not sys.stdout.isatty()
    with invocation.open_node() as node, contextlib.ExitStack() as subscriptions:
        curves: list[_Curve] = []
        curves_by_topic: dict[str, list[_Curve]] = {}
        for curve_name in curve_names:
            topic_match = wait_for_topic(invocation, node, (split_expression(curve_name) or (curve_name,))[0])
            if topic_match is None:
                return
            curve = _Curve(curve_name, expression_readers[curve_name] or _field_reader(topic_match[1]))
            curves.append(curve)
            curves_by_topic.setdefault(topic_match[0], []).append(curve)
        for topic, topic_curves in curves_by_topic.items():
            subscriptions.enter_context(subscribe(node, topic, _CurveFeeder(topic_curves).on_message))
        if draws_once:
            _collect_points(invocation, curves, options.period)
            print(_draw_chart(curves, options.period))
            return
        with _alternate_screen():
            while invocation.pause(_REFRESH_PERIOD):
                _raise_curve_error(curves)
                sys.stdout.write(_CLEAR_SCREEN + _draw_chart(curves, options.period))
                sys.stdout.flush()
    _raise_curve_error(curves)


VERB = Verb(
    "plot",
    "draw numbers as curves in the terminal",
    Option("-p", "--period", type="float", default=10.0, metavar="SECONDS", help="seconds to show (10)"),
    Flag("-n", "--once", help="draw one chart at the end of the period and exit"),
    Argument("/topic/field", "topic", repeatable=True),
    usage="[options] /topic/field[:field...] ...",
    examples=[
        ("/velocity/data", "draw one curve in the terminal"),
        ("/imu/linear_acceleration/x:y:z", "draw three fields of one message"),
        (
            "'/odom: hypot(m.twist.twist.linear.x, m.twist.twist.linear.y)'",
            "evaluate a Python expression for each message (available as m) and draw the results",
        ),
    ],
    stock="",
    run=run,
)


def _collect_points(invocation: Invocation, curves: list[_Curve], period: float) -> None:
    deadline = monotonic() + period
    while monotonic() < deadline and invocation.pause(min(_REFRESH_PERIOD, max(0.0, deadline - monotonic()))):
        _raise_curve_error(curves)


def _raise_curve_error(curves: list[_Curve]) -> None:
    for curve in curves:
        if curve.error is not None:
            raise CommandError(curve.error)


def _draw_chart(curves: list[_Curve], period: float) -> str:
    terminal_size = shutil.get_terminal_size((100, 30))
    labelled_points = [(curve.name, list(curve.points)) for curve in curves]
    return render_chart(
        labelled_points,
        monotonic(),
        period,
        (terminal_size.columns, terminal_size.lines - 1),
        should_use_colour(sys.stdout),
    )


@contextlib.contextmanager
def _alternate_screen() -> Iterator[None]:
    """Use the terminal's alternate screen, so that its previous contents are restored afterwards."""
    sys.stdout.write(_ENTER_ALTERNATE_SCREEN)
    try:
        yield
    finally:
        sys.stdout.write(_LEAVE_ALTERNATE_SCREEN)
        sys.stdout.flush()


def _field_reader(path: str) -> Callable[[Any], Any]:
    field = FieldPath(path)
    return lambda message: field.get(message)[0]


def _expression_reader(curve_name: str) -> Callable[[Any], Any] | None:
    """Return a function that evaluates the expression in a curve's name on a message; None if the name is a field."""
    topic_and_code = split_expression(curve_name)
    if topic_and_code is None:
        return None
    expression = Expression(topic_and_code[1])
    return lambda message: expression({"m": message})


class _Curve:
    def __init__(self, name: str, read_value: Callable[[Any], Any]) -> None:
        self.name = name
        self._read_value = read_value
        self.points: deque[tuple[float, float]] = deque(maxlen=_MAX_POINTS)
        self.error: str | None = None

    def add(self, now: float, message: Any) -> None:
        try:
            value = self._read_value(message)
        except (FieldPathError, ExpressionError) as error:
            self.error = f"{self.name}: {error}"
            return
        if isinstance(value, Message) and len(value.__slots__) == 1:  # the number in a std_msgs/Float64
            value = getattr(value, value.__slots__[0])
        if isinstance(value, TVal):
            value = value.to_sec()
        if not isinstance(value, (int, float)):
            description = (
                f"fields {', '.join(value.__slots__)}" if hasattr(value, "__slots__") else type(value).__name__
            )
            self.error = f"{self.name} is not a number ({description}): name one of its fields or elements"
            return
        self.points.append((now, float(value)))


class _CurveFeeder:
    """Decodes each message of a topic and adds it to all of the topic's curves."""

    def __init__(self, curves: list[_Curve]) -> None:
        self._curves = curves
        self._decoder = Decoder()

    def on_message(self, raw: AnyMsg) -> None:
        now = monotonic()
        try:
            message = self._decoder.decode(raw)
        except MessageError as error:
            self._curves[0].error = f"{self._curves[0].name}: {error}"
            return
        for curve in self._curves:
            curve.add(now, message)
