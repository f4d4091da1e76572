"""``topic plot``: numbers as curves in the terminal; fields are named as for rqt_plot (L209)."""

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
from pyros1.cli.shared.chart import draw
from pyros1.cli.shared.curves import curves_of, fields_of_messages
from pyros1.cli.shared.printing import use_colour
from pyros1.cli.shared.subscribing import find_topic, subscribe
from pyros1.ground.errors import MessageError
from pyros1.ground.timing import TVal
from pyros1.msgs import AnyMsg, Message
from pyros1.observe.decoder import Decoder
from pyros1.observe.expression import Expression, ExpressionError
from pyros1.observe.fields import FieldPath, FieldPathError, split_expression

_MAX_POINTS = 20_000
_FRAME = 0.1
_HOME, _BEGIN, _END = "\033[H\033[J", "\033[?1049h\033[?25l", "\033[?25h\033[?1049l"


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Draw numeric fields as curves over time."""
    if not args:
        raise UsageError("a topic with a field must be specified")
    if not options.period > 0:
        raise UsageError("the period must be greater than zero")
    names = fields_of_messages(invocation, [name for arg in args for name in curves_of(invocation, arg)])
    try:
        read = {name: _expression_reader(name) for name in names}
    except ExpressionError as error:
        raise UsageError(str(error)) from None
    once = bool(options.once) or not sys.stdout.isatty()
    with invocation.open_node() as node, contextlib.ExitStack() as subscriptions:
        curves: list[_Curve] = []
        by_topic: dict[str, list[_Curve]] = {}
        for name in names:
            found = find_topic(invocation, node, (split_expression(name) or (name,))[0])
            if found is None:
                return
            curve = _Curve(name, read[name] or _field_reader(found[1]))
            curves.append(curve)
            by_topic.setdefault(found[0], []).append(curve)
        for topic, its in by_topic.items():
            subscriptions.enter_context(subscribe(node, topic, _Feeder(its).arrived))
        if once:
            _wait(invocation, curves, options.period)
            print(_chart(curves, options.period))
            return
        with _screen():
            while invocation.pause(_FRAME):
                _check(curves)
                sys.stdout.write(_HOME + _chart(curves, options.period))
                sys.stdout.flush()
    _check(curves)


VERB = Verb(
    "plot",
    "draw numbers as curves in the terminal",
    Option("-p", "--period", type="float", default=10.0, metavar="SECONDS", help="seconds to show (10)"),
    Flag("-n", "--once", help="draw one chart at the end of the period, and exit"),
    Argument("/topic/field", "topic", many=True),
    usage="[options] /topic/field[:field...] ...",
    examples=[
        ("/velocity/data", "one curve in the terminal"),
        ("/imu/linear_acceleration/x:y:z", "three fields of one message"),
        (
            "'/odom: hypot(m.twist.twist.linear.x, m.twist.twist.linear.y)'",
            "the value of an expression of each message m",
        ),
    ],
    stock="",
    run=run,
)


def _wait(invocation: Invocation, curves: list[_Curve], period: float) -> None:
    until = monotonic() + period
    while monotonic() < until and invocation.pause(min(_FRAME, max(0.0, until - monotonic()))):
        _check(curves)


def _check(curves: list[_Curve]) -> None:
    for curve in curves:
        if curve.error is not None:
            raise CommandError(curve.error)


def _chart(curves: list[_Curve], period: float) -> str:
    size = shutil.get_terminal_size((100, 30))
    table = [(curve.name, list(curve.points)) for curve in curves]
    return draw(table, monotonic(), period, (size.columns, size.lines - 1), use_colour(sys.stdout))


@contextlib.contextmanager
def _screen() -> Iterator[None]:
    """Use the terminal's alternate screen, so that its content is restored afterwards."""
    sys.stdout.write(_BEGIN)
    try:
        yield
    finally:
        sys.stdout.write(_END)
        sys.stdout.flush()


def _field_reader(path: str) -> Callable[[Any], Any]:
    field = FieldPath(path)
    return lambda message: field.get(message)[0]


def _expression_reader(name: str) -> Callable[[Any], Any] | None:
    """Return a function that evaluates an expression on a message; None for a field."""
    split = split_expression(name)
    if split is None:
        return None
    expression = Expression(split[1])
    return lambda message: expression({"m": message})


class _Curve:
    def __init__(self, name: str, read: Callable[[Any], Any]) -> None:
        self.name = name
        self.read = read
        self.points: deque[tuple[float, float]] = deque(maxlen=_MAX_POINTS)
        self.error: str | None = None

    def add(self, now: float, message: Any) -> None:
        try:
            value = self.read(message)
        except (FieldPathError, ExpressionError) as error:
            self.error = f"{self.name}: {error}"
            return
        if isinstance(value, Message) and len(value.__slots__) == 1:  # the number in a std_msgs/Float64
            value = getattr(value, value.__slots__[0])
        if isinstance(value, TVal):
            value = value.to_sec()
        if not isinstance(value, (int, float)):
            what = f"fields {', '.join(value.__slots__)}" if hasattr(value, "__slots__") else type(value).__name__
            self.error = f"{self.name} is not a number ({what}): name one of its fields or elements"
            return
        self.points.append((now, float(value)))


class _Feeder:
    """Decodes each message of a topic once for all curves."""

    def __init__(self, curves: list[_Curve]) -> None:
        self._curves = curves
        self._decoder = Decoder()

    def arrived(self, raw: AnyMsg) -> None:
        now = monotonic()
        try:
            message = self._decoder.decode(raw)
        except MessageError as error:
            self._curves[0].error = f"{self._curves[0].name}: {error}"
            return
        for curve in self._curves:
            curve.add(now, message)
