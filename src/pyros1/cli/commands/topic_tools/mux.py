"""``topic_tools mux`` (L190)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.topic_tools._tool import LAZY, Tool, flag, number, open_node_for
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish one of several topics, until the node ends."""
    from pyros1.topic_tools.mux import Mux  # noqa: PLC0415

    if len(args) < 2:
        raise UsageError("")
    target, *sources = args
    with open_node_for(invocation, target, "mux") as node:
        lazy, latch, wait = (flag(node, name) for name in ("lazy", "latch", "wait_publisher_initialization"))
        patience = number(node, "wait_publisher_second", 0.1) if wait else 0.0
        initial = str(node.params.get("~initial_topic", ""))
        node.log.info("mux from %s to %s", ", ".join(sources), target)
        Mux(node, target, sources, initial, lazy, latch, patience).run()


VERB = Tool(
    "mux",
    "republish one of several topics, selected by the service mux/select",
    Argument("OUT_TOPIC", "topic"),
    Argument("IN_TOPIC", "topic", many=True),
    usage="OUT_TOPIC IN_TOPIC1 [IN_TOPIC2 [...]]",
    parameters=[
        LAZY,
        "_latch:=true       latch the output",
        "_initial_topic:=/topic (or __none) select it at the start",
        "_wait_publisher_initialization:=true the first message waits _wait_publisher_second:=0.1 for subscribers",
    ],
    examples=[("/cmd_vel /joystick /planner mux:=mux_vel", "with the services mux_vel/select, mux_vel/add, ...")],
    run=run,
)
