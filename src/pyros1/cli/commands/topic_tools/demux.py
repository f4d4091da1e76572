"""``topic_tools demux`` (L191)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.topic_tools._tool import Tool, open_node_for
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic on one of several topics, until the node ends."""
    from pyros1.topic_tools.demux import Demux  # noqa: PLC0415

    if len(args) < 2:
        raise UsageError("")
    source, *targets = args
    with open_node_for(invocation, source, "demux") as node:
        node.log.info("demux from %s to %s", source, ", ".join(targets))
        Demux(node, source, targets).run()


VERB = Tool(
    "demux",
    "republish a topic on one of several topics, selected by the service demux/select",
    Argument("IN_TOPIC", "topic"),
    Argument("OUT_TOPIC", "topic", many=True),
    usage="IN_TOPIC OUT_TOPIC1 [OUT_TOPIC2 [...]]",
    examples=[("/cmd /left/cmd /right/cmd", "with the services demux/select, demux/add, ...")],
    run=run,
)
