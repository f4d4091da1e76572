"""``topic delay`` (L66)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.commands.topic._standstill import Standstill
from pyros1.cli.commands.topic._window import PERIOD, TCPNODELAY, WINDOW, window
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.cli.shared.subscribing import find_topic, subscribe
from pyros1.ground.errors import MessageError
from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.observe.statistics import DelayMeter


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print every second the age of messages at their arrival, by the stamps of their headers."""
    if not args:
        raise UsageError("the following arguments are required: topic")
    if len(args) > 1:
        raise UsageError(f"unrecognized arguments: {' '.join(args[1:])}")
    meter = DelayMeter(window(options))
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

        standstill = Standstill(node)
        with subscribe(node, found[0], arrived):
            print(f"subscribed to [{name}]", flush=True)
            while invocation.pause(PERIOD):
                if failures:
                    raise CommandError(failures[0])
                lines = meter.lines()
                standstill.lasts()
                if lines is not None:
                    print(lines, flush=True)


VERB = Verb(
    "delay",
    "display delay of topic from timestamp in header",
    WINDOW,
    TCPNODELAY,
    Argument("/topic", "topic"),
    usage="[options] /topic",
    examples=[("/image", "the age of messages at their arrival")],
    run=run,
)
