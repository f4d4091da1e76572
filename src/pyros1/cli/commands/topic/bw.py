"""``topic bw`` (L65)."""

from __future__ import annotations

from time import time
from typing import Any

from pyros1.cli.commands.topic._window import PERIOD, WINDOW, window
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.cli.shared.subscribing import find_topic, subscribe
from pyros1.observe.statistics import BandwidthMeter


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the bandwidth every second."""
    if not args:
        raise UsageError("topic must be specified")
    if len(args) > 1:
        raise UsageError("you may only specify one input topic")
    meter = BandwidthMeter(window(options))
    name = invocation.resolve(args[0])
    with invocation.open_node() as node:
        found = find_topic(invocation, node, name)
        if found is None:
            return
        with subscribe(node, found[0], lambda raw: meter.arrived(time(), len(raw._buff))):
            print(f"subscribed to [{name}]", flush=True)
            while invocation.pause(PERIOD):
                lines = meter.lines(time())
                if lines is not None:
                    print(lines, flush=True)


VERB = Verb(
    "bw",
    "display bandwidth used by topic",
    WINDOW,
    Argument("/topic", "topic"),
    usage="/topic",
    examples=[("/image", "bytes per second")],
    run=run,
)
