"""``topic_tools drop`` (L188)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.topic_tools._tool import Tool, make_relay, open_node_for, topics
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic without some of its messages, until the node ends."""
    from pyros1.topic_tools.drop import Drop  # noqa: PLC0415

    if len(args) not in (3, 4):
        raise UsageError("")
    dropped, among = _integer(args[1], "X", 0), _integer(args[2], "Y", 1)
    source, target = topics([args[0], *args[3:]], "drop")
    with open_node_for(invocation, source, "drop") as node:
        relay, _output = make_relay(node, source, target, Drop(dropped, among), latch=False)
        node.log.info("drop %d of every %d messages from %s to %s", dropped, among, source, target)
        relay.run()


VERB = Tool(
    "drop",
    "republish a topic without the first X of every Y messages (default: as IN_TOPIC_drop)",
    Argument("IN_TOPIC", "topic"),
    Argument("X"),
    Argument("Y"),
    Argument("OUT_TOPIC", "topic", optional=True),
    examples=[("/scan 4 5 /few", "every fifth message")],
    run=run,
)


def _integer(text: str, name: str, least: int) -> int:
    try:
        value = int(text)
    except ValueError:
        raise UsageError(f"{name} must be a whole number, not {text!r}") from None
    if value < least:
        raise UsageError(f"{name} must be at least {least}, not {value}")
    return value
