"""``topic_tools relay`` (L187)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.topic_tools._tool import LAZY, Tool, flag, make_relay, number, open_node_for, topics
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic, until the node ends."""
    source, target = topics(args, "relay")
    with open_node_for(invocation, source, "relay") as node:
        lazy, stealth = (flag(node, name) for name in ("lazy", "stealth"))
        monitor = str(node.params.get("~monitor_topic", target))
        rate = number(node, "monitor_rate", 1.0)
        relay, _output = make_relay(node, source, target)
        node.log.info("relay from %s to %s%s", source, target, ", stealthy" if stealth else ", lazy" if lazy else "")
        if stealth:
            relay.run_stealth(monitor, 1.0 / rate)
        elif lazy:
            relay.run_lazy()
        else:
            relay.run()


VERB = Tool(
    "relay",
    "republish a topic (default: as IN_TOPIC_relay)",
    Argument("IN_TOPIC", "topic"),
    Argument("OUT_TOPIC", "topic", optional=True),
    parameters=[
        LAZY,
        "_stealth:=true     subscribe only while another node subscribes to _monitor_topic:=/topic (the output),",
        "                   checked _monitor_rate:=1.0 times per second",
    ],
    examples=[("/base_scan /scan", "publish a topic under a second name")],
    run=run,
)
