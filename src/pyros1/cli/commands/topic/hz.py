"""``topic hz`` (L64)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from time import time
from typing import Any

from pyros1.cli.commands.topic._standstill import Standstill
from pyros1.cli.commands.topic._window import PERIOD, TCPNODELAY, WINDOW, window
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.filters import Clock, filter_expression
from pyros1.cli.shared.subscribing import find_topic, subscribe
from pyros1.ground.errors import MessageError
from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.observe.expression import Expression, ExpressionError
from pyros1.observe.statistics import RateMeter, rate_lines, rate_table


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the rate of messages every second."""
    if not args:
        raise UsageError("topic must be specified")
    size = window(options)
    clock = Clock()
    expression = filter_expression(options.filter_expr, clock) if options.filter_expr else None
    with invocation.open_node() as node, ExitStack() as subscriptions:
        clock.node = node
        simulated = not options.wall_time and node.params.get("/use_sim_time", False) is True
        now: Callable[[], float] = (lambda: node.now().to_sec()) if simulated else time
        standstill = Standstill(node, " --wall-time measures without it.") if simulated else None
        meters: dict[str, RateMeter] = {}
        for name in map(invocation.resolve, args):
            found = find_topic(invocation, node, name)
            if found is None:
                return
            meter = meters[name] = RateMeter(size)
            callback = _counting(meter, now, expression, found[0], found[2])
            subscriptions.enter_context(subscribe(node, found[0], callback))
            print(f"subscribed to [{name}]", flush=True)
        while invocation.pause(PERIOD):
            figures = {name: meter.figures() for name, meter in meters.items()}
            fresh = {name: figure for name, figure in figures.items() if figure is not None}
            if standstill and standstill.lasts():
                fresh = {}  # all in no time: that is no rate
            if not fresh:
                print("no new messages", flush=True)
            elif len(meters) == 1:
                print(rate_lines(*next(iter(fresh.values()))), flush=True)
            else:
                print(rate_table(fresh), flush=True)


VERB = Verb(
    "hz",
    "display publishing rate of topic",
    WINDOW,
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
    TCPNODELAY,
    Argument("/topic", "topic", many=True),
    usage="[options] /topic_0 [/topic_1 [topic_2 [..]]]",
    examples=[("/scan", "the rate of messages"), ("/a /b", "a table of several topics")],
    stock_about="display publishing rate of topic    ",
    run=run,
)


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
