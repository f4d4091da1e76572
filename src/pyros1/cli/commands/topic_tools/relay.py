"""``topic_tools relay`` and ``drop``: republish a topic, completely or without some messages (L187, L188)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.topic_tools._tool import (
    LAZY_HELP,
    Tool,
    bool_param,
    input_and_output,
    make_relay,
    open_node_for,
    positive_param,
)
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def _run_relay(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic until the node shuts down."""
    source, target = input_and_output(args, "relay")
    with open_node_for(invocation, source, "relay") as node:
        lazy, stealth = (bool_param(node, name) for name in ("lazy", "stealth"))
        monitored_topic = str(node.params.get("~monitor_topic", target))
        rate = positive_param(node, "monitor_rate", 1.0)
        relay, _output = make_relay(node, source, target)
        node.log.info("relay from %s to %s%s", source, target, ", stealthy" if stealth else ", lazy" if lazy else "")
        if stealth:
            relay.run_stealth(monitored_topic, 1.0 / rate)
        elif lazy:
            relay.run_lazy()
        else:
            relay.run()


def _run_drop(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic without some of its messages until the node shuts down."""
    from pyros1.topic_tools.gates import Drop  # noqa: PLC0415

    if len(args) not in (3, 4):
        raise UsageError("")
    dropped_count, group_size = _parse_integer(args[1], "X", 0), _parse_integer(args[2], "Y", 1)
    source, target = input_and_output([args[0], *args[3:]], "drop")
    with open_node_for(invocation, source, "drop") as node:
        relay, _output = make_relay(node, source, target, Drop(dropped_count, group_size), latch=False)
        node.log.info("drop %d of every %d messages from %s to %s", dropped_count, group_size, source, target)
        relay.run()


def _parse_integer(text: str, name: str, minimum: int) -> int:
    try:
        value = int(text)
    except ValueError:
        raise UsageError(f"{name} must be a whole number, not {text!r}") from None
    if value < minimum:
        raise UsageError(f"{name} must be at least {minimum}, not {value}")
    return value


VERBS = [
    Tool(
        "relay",
        "republish a topic (default: as IN_TOPIC_relay)",
        Argument("IN_TOPIC", "topic"),
        Argument("OUT_TOPIC", "topic", optional=True),
        parameters=[
            LAZY_HELP,
            "_stealth:=true     subscribe only while another node subscribes to _monitor_topic:=/topic (default: the",
            "                   output topic), which is checked _monitor_rate:=1.0 times per second",
        ],
        examples=[("/base_scan /scan", "publish a topic under a second name")],
        run=_run_relay,
    ),
    Tool(
        "drop",
        "republish a topic without the first X of every Y messages (default: as IN_TOPIC_drop)",
        Argument("IN_TOPIC", "topic"),
        Argument("X"),
        Argument("Y"),
        Argument("OUT_TOPIC", "topic", optional=True),
        examples=[("/scan 4 5 /few", "publish every fifth message")],
        run=_run_drop,
    ),
]
