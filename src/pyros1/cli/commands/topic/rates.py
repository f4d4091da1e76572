"""``topic hz``, ``bw`` and ``delay``: measure the rate, bandwidth and delay of messages (L64-L66).

Messages are only decoded if a filter or the header stamp is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from time import time
from typing import Any

from pyros1.cli.commands.topic._stopped_clock import StoppedClockDetector
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.filters import ExpressionClock, filter_expression
from pyros1.cli.shared.subscribing import subscribe, wait_for_topic
from pyros1.ground.errors import MessageError
from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.observe.expression import Expression, ExpressionError
from pyros1.observe.statistics import BandwidthMeter, DelayMeter, RateMeter, rate_lines, rate_table

_OUTPUT_PERIOD = 1.0
"""Seconds between two outputs."""
_WINDOW_OPTION = Option(
    "-w",
    "--window",
    dest="window_size",
    metavar="WINDOW",
    help="window size, in # of messages, for calculating rate",
)
_TCPNODELAY_OPTION = Flag("--tcpnodelay", help="use the TCP_NODELAY transport hint when subscribing to topics")


def _window_size(options: Any) -> int:
    """Return the window size in messages; -1 if none is given."""
    if options.window_size is None:
        return -1
    try:
        size = int(options.window_size)
    except ValueError:
        raise UsageError("window size must be an integer") from None
    return size if size > 0 else -1


def _print_rates(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the rate of messages on one or more topics every second."""
    if not args:
        raise UsageError("topic must be specified")
    window_size = _window_size(options)
    clock = ExpressionClock()
    expression = filter_expression(options.filter_expr, clock) if options.filter_expr else None
    with invocation.open_node() as node, ExitStack() as subscriptions:
        clock.node = node
        uses_simulated_time = not options.wall_time and node.params.get("/use_sim_time", False) is True
        now: Callable[[], float] = (lambda: node.now().to_sec()) if uses_simulated_time else time
        stopped_clock = (
            StoppedClockDetector(node, " With --wall-time, wall time is used instead.") if uses_simulated_time else None
        )
        meters: dict[str, RateMeter] = {}
        for name in map(invocation.resolve, args):
            topic_match = wait_for_topic(invocation, node, name)
            if topic_match is None:
                return
            meter = meters[name] = RateMeter(window_size)
            callback = _make_rate_callback(meter, now, expression, topic_match[0], topic_match[2])
            subscriptions.enter_context(subscribe(node, topic_match[0], callback))
            print(f"subscribed to [{name}]", flush=True)
        while invocation.pause(_OUTPUT_PERIOD):
            rates = {name: meter.measurement() for name, meter in meters.items()}
            new_rates = {name: rate for name, rate in rates.items() if rate is not None}
            if stopped_clock and stopped_clock.warn_if_stopped():
                new_rates = {}  # rates cannot be computed, since no time has passed
            if not new_rates:
                print("no new messages", flush=True)
            elif len(meters) == 1:
                print(rate_lines(*next(iter(new_rates.values()))), flush=True)
            else:
                print(rate_table(new_rates), flush=True)


def _make_rate_callback(
    meter: RateMeter, now: Callable[[], float], expression: Expression | None, topic: str, type_name: str
) -> Callable[[AnyMsg], None]:
    if expression is None:
        add = meter.add
        return lambda raw: add(now())
    decoder = Decoder(type_name)
    printed_errors: set[str] = set()

    def count_matching(raw: AnyMsg) -> None:
        arrival_time = now()
        try:
            if expression({"m": decoder.decode(raw), "topic": topic}):
                meter.add(arrival_time)
        except (ExpressionError, MessageError) as error:
            if str(error) not in printed_errors:
                printed_errors.add(str(error))
                print(error, file=sys.stderr, flush=True)

    return count_matching


def _print_bandwidth(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the bandwidth of a topic every second."""
    if not args:
        raise UsageError("topic must be specified")
    if len(args) > 1:
        raise UsageError("you may only specify one input topic")
    meter = BandwidthMeter(_window_size(options))
    name = invocation.resolve(args[0])
    with invocation.open_node() as node:
        topic_match = wait_for_topic(invocation, node, name)
        if topic_match is None:
            return
        with subscribe(node, topic_match[0], lambda raw: meter.add(time(), len(raw._buff))):
            print(f"subscribed to [{name}]", flush=True)
            while invocation.pause(_OUTPUT_PERIOD):
                report = meter.lines(time())
                if report is not None:
                    print(report, flush=True)


def _print_delays(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print every second how old messages are on arrival, according to their header stamps."""
    if not args:
        raise UsageError("the following arguments are required: topic")
    if len(args) > 1:
        raise UsageError(f"unrecognized arguments: {' '.join(args[1:])}")
    meter = DelayMeter(_window_size(options))
    name = invocation.resolve(args[0])
    failures: list[str] = []
    with invocation.open_node() as node:
        topic_match = wait_for_topic(invocation, node, name)
        if topic_match is None:
            return
        decoder = Decoder(topic_match[2])
        printed_errors: set[str] = set()

        def on_message(raw: AnyMsg) -> None:
            now = node.now()
            try:
                if not decoder.message_class(raw)._has_header:
                    failures.append("msg does not have header")
                    return
                message: Any = decoder.decode(raw)
            except MessageError as error:
                if str(error) not in printed_errors:
                    printed_errors.add(str(error))
                    print(error, file=sys.stderr, flush=True)
                return
            meter.add((now - message.header.stamp).to_sec())

        stopped_clock = StoppedClockDetector(node)
        with subscribe(node, topic_match[0], on_message):
            print(f"subscribed to [{name}]", flush=True)
            while invocation.pause(_OUTPUT_PERIOD):
                if failures:
                    raise CommandError(failures[0])
                report = meter.lines()
                stopped_clock.warn_if_stopped()
                if report is not None:
                    print(report, flush=True)


VERBS = [
    Verb(
        "hz",
        "display publishing rate of topic",
        _WINDOW_OPTION,
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
        _TCPNODELAY_OPTION,
        Argument("/topic", "topic", repeatable=True),
        usage="[options] /topic_0 [/topic_1 [topic_2 [..]]]",
        examples=[("/scan", "print the rate of messages"), ("/a /b", "print a table of several topics")],
        stock_about="display publishing rate of topic    ",
        run=_print_rates,
    ),
    Verb(
        "bw",
        "display bandwidth used by topic",
        _WINDOW_OPTION,
        Argument("/topic", "topic"),
        usage="/topic",
        examples=[("/image", "print bytes per second")],
        run=_print_bandwidth,
    ),
    Verb(
        "delay",
        "display delay of topic from timestamp in header",
        _WINDOW_OPTION,
        _TCPNODELAY_OPTION,
        Argument("/topic", "topic"),
        usage="[options] /topic",
        examples=[("/image", "print how old messages are on arrival")],
        run=_print_delays,
    ),
]
