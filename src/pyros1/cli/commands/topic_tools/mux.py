"""``topic_tools mux`` and ``demux``: republish one of several topics, or a topic on one of several (L190, L191)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.topic_tools._tool import LAZY_HELP, Tool, bool_param, open_node_for, positive_param
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def _run_mux(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish one of several topics until the node shuts down."""
    from pyros1.topic_tools.mux import Mux  # noqa: PLC0415

    if len(args) < 2:
        raise UsageError("")
    target, *sources = args
    with open_node_for(invocation, target, "mux") as node:
        lazy, latch, waits = (bool_param(node, name) for name in ("lazy", "latch", "wait_publisher_initialization"))
        connect_timeout = positive_param(node, "wait_publisher_second", 0.1) if waits else 0.0
        initial_topic = str(node.params.get("~initial_topic", ""))
        node.log.info("mux from %s to %s", ", ".join(sources), target)
        Mux(node, target, sources, initial_topic, lazy, latch, connect_timeout).run()


def _run_demux(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic on one of several topics until the node shuts down."""
    from pyros1.topic_tools.demux import Demux  # noqa: PLC0415

    if len(args) < 2:
        raise UsageError("")
    source, *targets = args
    with open_node_for(invocation, source, "demux") as node:
        node.log.info("demux from %s to %s", source, ", ".join(targets))
        Demux(node, source, targets).run()


VERBS = [
    Tool(
        "mux",
        "republish one of several input topics; the service mux/select selects the input",
        Argument("OUT_TOPIC", "topic"),
        Argument("IN_TOPIC", "topic", repeatable=True),
        usage="OUT_TOPIC IN_TOPIC1 [IN_TOPIC2 [...]]",
        parameters=[
            LAZY_HELP,
            "_latch:=true       latch the output",
            "_initial_topic:=/topic (or __none) topic to select at the start",
            "_wait_publisher_initialization:=true wait up to _wait_publisher_second:=0.1 s for subscribers at start",
        ],
        examples=[
            ("/cmd_vel /joystick /planner mux:=mux_vel", "provide the services mux_vel/select, mux_vel/add, ...")
        ],
        run=_run_mux,
    ),
    Tool(
        "demux",
        "republish a topic on one of several output topics; the service demux/select selects the output",
        Argument("IN_TOPIC", "topic"),
        Argument("OUT_TOPIC", "topic", repeatable=True),
        usage="IN_TOPIC OUT_TOPIC1 [OUT_TOPIC2 [...]]",
        examples=[("/cmd /left/cmd /right/cmd", "provide the services demux/select, demux/add, ...")],
        run=_run_demux,
    ),
]
