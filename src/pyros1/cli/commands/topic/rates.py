"""``topic hz``, ``bw`` and ``delay`` (L64-L66). Messages are decoded only for a filter or a stamp."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from time import time
from typing import Any

from pyros1.cli.commands.topic._stopped_clock import StoppedClock
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.filters import Clock, filter_expression
from pyros1.cli.shared.subscribing import find_topic, subscribe
from pyros1.ground.errors import MessageError
from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.observe.expression import Expression, ExpressionError
from pyros1.observe.statistics import BandwidthMeter, DelayMeter, RateMeter, rate_lines, rate_table

_PERIOD = 1.0
"""Seconds between two lines of output."""
_WINDOW = Option(
    "-w",
    "--window",
    dest="window_size",
    metavar="WINDOW",
    help="window size, in # of messages, for calculating rate",
)
_TCPNODELAY = Flag("--tcpnodelay", help="use the TCP_NODELAY transport hint when subscribing to topics")


def _window(options: Any) -> int:
    """Return the window size in messages, -1 if none was given."""
    if options.window_size is None:
        return -1
    try:
        size = int(options.window_size)
    except ValueError:
        raise UsageError("window size must be an integer") from None
    return size if size > 0 else -1


def _hz(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the rate of messages every second."""
    if not args:
        raise UsageError("topic must be specified")
    size = _window(options)
    clock = Clock()
    expression = filter_expression(options.filter_expr, clock) if options.filter_expr else None
    with invocation.open_node() as node, ExitStack() as subscriptions:
        clock.node = node
        simulated = not options.wall_time and node.params.get("/use_sim_time", False) is True
        now: Callable[[], float] = (lambda: node.now().to_sec()) if simulated else time
        stopped_clock = StoppedClock(node, " --wall-time measures without it.") if simulated else None
        meters: dict[str, RateMeter] = {}
        for name in map(invocation.resolve, args):
            found = find_topic(invocation, node, name)
            if found is None:
                return
            meter = meters[name] = RateMeter(size)
            callback = _counting(meter, now, expression, found[0], found[2])
            subscriptions.enter_context(subscribe(node, found[0], callback))
            print(f"subscribed to [{name}]", flush=True)
        while invocation.pause(_PERIOD):
            figures = {name: meter.figures() for name, meter in meters.items()}
            fresh = {name: figure for name, figure in figures.items() if figure is not None}
            if stopped_clock and stopped_clock.has_stopped():
                fresh = {}  # no time has passed, so there is no rate
            if not fresh:
                print("no new messages", flush=True)
            elif len(meters) == 1:
                print(rate_lines(*next(iter(fresh.values()))), flush=True)
            else:
                print(rate_table(fresh), flush=True)


def _counting(
    meter: RateMeter, now: Callable[[], float], expression: Expression | None, topic: str, kind: str
) -> Callable[[AnyMsg], None]:
    if expression is None:
        arrived = meter.arrived
        return lambda raw: arrived(now())
    decoder = Decoder(kind)
    said: set[str] = set()

    def filtered(raw: AnyMsg) -> None:
        moment = now()
        try:
            if expression({"m": decoder.decode(raw), "topic": topic}):
                meter.arrived(moment)
        except (ExpressionError, MessageError) as error:
            if str(error) not in said:
                said.add(str(error))
                print(error, file=sys.stderr, flush=True)

    return filtered


def _bw(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the bandwidth every second."""
    if not args:
        raise UsageError("topic must be specified")
    if len(args) > 1:
        raise UsageError("you may only specify one input topic")
    meter = BandwidthMeter(_window(options))
    name = invocation.resolve(args[0])
    with invocation.open_node() as node:
        found = find_topic(invocation, node, name)
        if found is None:
            return
        with subscribe(node, found[0], lambda raw: meter.arrived(time(), len(raw._buff))):
            print(f"subscribed to [{name}]", flush=True)
            while invocation.pause(_PERIOD):
                lines = meter.lines(time())
                if lines is not None:
                    print(lines, flush=True)


def _delay(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print every second the age of messages at their arrival, by the stamps of their headers."""
    if not args:
        raise UsageError("the following arguments are required: topic")
    if len(args) > 1:
        raise UsageError(f"unrecognized arguments: {' '.join(args[1:])}")
    meter = DelayMeter(_window(options))
    name = invocation.resolve(args[0])
    failures: list[str] = []
    with invocation.open_node() as node:
        found = find_topic(invocation, node, name)
        if found is None:
            return
        decoder = Decoder(found[2])
        said: set[str] = set()

        def arrived(raw: AnyMsg) -> None:
            now = node.now()
            try:
                if not decoder.message_class(raw)._has_header:
                    failures.append("msg does not have header")
                    return
                message: Any = decoder.decode(raw)
            except MessageError as error:
                if str(error) not in said:
                    said.add(str(error))
                    print(error, file=sys.stderr, flush=True)
                return
            meter.arrived((now - message.header.stamp).to_sec())

        stopped_clock = StoppedClock(node)
        with subscribe(node, found[0], arrived):
            print(f"subscribed to [{name}]", flush=True)
            while invocation.pause(_PERIOD):
                if failures:
                    raise CommandError(failures[0])
                lines = meter.lines()
                stopped_clock.has_stopped()
                if lines is not None:
                    print(lines, flush=True)


VERBS = [
    Verb(
        "hz",
        "display publishing rate of topic",
        _WINDOW,
        Option(
            "--filter",
            dest="filter_expr",
            metavar="EXPR",
            help="only measure messages matching the specified Python expression",
        ),
        Flag(
            "--wall-time",
            help="calculates rate using wall time which can be helpful when clock isn't published during simulation",
        ),
        _TCPNODELAY,
        Argument("/topic", "topic", many=True),
        usage="[options] /topic_0 [/topic_1 [topic_2 [..]]]",
        examples=[("/scan", "the rate of messages"), ("/a /b", "a table of several topics")],
        stock_about="display publishing rate of topic    ",
        run=_hz,
    ),
    Verb(
        "bw",
        "display bandwidth used by topic",
        _WINDOW,
        Argument("/topic", "topic"),
        usage="/topic",
        examples=[("/image", "bytes per second")],
        run=_bw,
    ),
    Verb(
        "delay",
        "display delay of topic from timestamp in header",
        _WINDOW,
        _TCPNODELAY,
        Argument("/topic", "topic"),
        usage="[options] /topic",
        examples=[("/image", "the age of messages at their arrival")],
        run=_delay,
    ),
]
