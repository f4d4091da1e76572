"""``topic hz``, ``bw`` and ``delay`` (L64-L66). Messages are not decoded unless a filter or a stamp is asked for."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from time import time
from typing import Any

from pyros1.cli.common import CommandError, Invocation
from pyros1.cli.expression import Expression, ExpressionError
from pyros1.cli.statistics import BandwidthMeter, DelayMeter, RateMeter, rate_lines, rate_table
from pyros1.cli.subscribing import Decoder, find_topic, subscribe
from pyros1.msgs import AnyMsg

_PERIOD = 1.0


def _window(parser: Any, options: Any) -> int:
    """The window that was asked for, -1 if none was."""
    if options.window_size is None:
        return -1
    try:
        window = int(options.window_size)
    except ValueError:
        parser.error("window size must be an integer")
    return window if window > 0 else -1


def _add_window(parser: Any) -> None:
    parser.add_option(
        "-w",
        "--window",
        dest="window_size",
        metavar="WINDOW",
        help="window size, in # of messages, for calculating rate",
    )


def hz(invocation: Invocation) -> None:
    """``topic hz [options] /topic...`` (L64)."""
    parser = invocation.parser("hz [options] /topic_0 [/topic_1 [topic_2 [..]]]")
    _add_window(parser)
    parser.add_option(
        "--filter",
        dest="filter_expr",
        metavar="EXPR",
        help="only measure messages matching the specified Python expression",
    )
    parser.add_option(
        "--wall-time",
        dest="wall_time",
        action="store_true",
        help="calculates rate using wall time which can be helpful when clock isn't published during simulation",
    )
    parser.add_option(
        "--tcpnodelay",
        action="store_true",
        help="use the TCP_NODELAY transport hint when subscribing to topics",
    )
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("topic must be specified")
    window = _window(parser, options)
    expression = Expression(options.filter_expr) if options.filter_expr else None
    with invocation.open_node() as node, ExitStack() as subscriptions:
        simulated = not options.wall_time and node.params.get("/use_sim_time", False) is True
        now: Callable[[], float] = (lambda: node.now().to_sec()) if simulated else time
        meters: dict[str, RateMeter] = {}
        for name in map(invocation.resolve, args):
            found = find_topic(invocation, node, name)
            if found is None:
                return
            meter = meters[name] = RateMeter(window)
            callback = _counting(meter, now, expression, found[0])
            subscriptions.enter_context(subscribe(node, found[0], callback))
            print(f"subscribed to [{name}]", flush=True)
        while invocation.pause(_PERIOD):
            figures = {name: meter.figures() for name, meter in meters.items()}
            fresh = {name: figure for name, figure in figures.items() if figure is not None}
            if not fresh:
                print("no new messages", flush=True)
            elif len(meters) == 1:
                print(rate_lines(*next(iter(fresh.values()))), flush=True)
            else:
                print(rate_table(fresh), flush=True)


def _counting(
    meter: RateMeter, now: Callable[[], float], expression: Expression | None, topic: str
) -> Callable[[AnyMsg], None]:
    if expression is None:
        arrived = meter.arrived
        return lambda raw: arrived(now())
    decoder = Decoder()
    said: set[str] = set()

    def filtered(raw: AnyMsg) -> None:
        moment = now()
        try:
            if expression({"m": decoder.decode(raw), "topic": topic}):
                meter.arrived(moment)
        except ExpressionError as error:
            if str(error) not in said:
                said.add(str(error))
                print(error, file=sys.stderr, flush=True)

    return filtered


def bandwidth(invocation: Invocation) -> None:
    """``topic bw /topic`` (L65)."""
    parser = invocation.parser("bw /topic")
    _add_window(parser)
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("topic must be specified")
    if len(args) > 1:
        parser.error("you may only specify one input topic")
    meter = BandwidthMeter(_window(parser, options))
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


def delay(invocation: Invocation) -> None:
    """``topic delay /topic`` (L66)."""
    parser = invocation.parser("delay [options] /topic")
    _add_window(parser)
    parser.add_option(
        "--tcpnodelay", action="store_true", help="use the TCP_NODELAY transport hint when subscribing to topics"
    )
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("the following arguments are required: topic")
    if len(args) > 1:
        parser.error(f"unrecognized arguments: {' '.join(args[1:])}")
    meter = DelayMeter(_window(parser, options))
    name = invocation.resolve(args[0])
    failures: list[str] = []
    with invocation.open_node() as node:
        found = find_topic(invocation, node, name)
        if found is None:
            return
        decoder = Decoder()

        def arrived(raw: AnyMsg) -> None:
            now = node.now()
            if not decoder.message_class(raw)._has_header:
                failures.append("msg does not have header")
                return
            message: Any = decoder.decode(raw)
            meter.arrived((now - message.header.stamp).to_sec())

        with subscribe(node, found[0], arrived):
            print(f"subscribed to [{name}]", flush=True)
            while invocation.pause(_PERIOD):
                if failures:
                    raise CommandError(failures[0])
                lines = meter.lines()
                if lines is not None:
                    print(lines, flush=True)
