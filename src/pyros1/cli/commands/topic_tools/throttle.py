"""``topic_tools throttle``: republishes a topic at a limited rate (L189)."""

from __future__ import annotations

import math
import time
from typing import Any

from pyros1.cli.commands.topic_tools._tool import (
    LAZY_HELP,
    Tool,
    bool_param,
    input_and_output,
    make_relay,
    open_node_for,
)
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic at a limited rate until the node shuts down."""
    from pyros1.topic_tools.gates import ByteThrottle, MessageThrottle  # noqa: PLC0415

    limit_kind = args[0] if args else ""
    number_names = {"messages": ["MSGS_PER_SEC"], "bytes": ["BYTES_PER_SEC", "WINDOW"]}.get(limit_kind)
    if number_names is None:
        raise UsageError(f"unknown limit {limit_kind!r}: use messages or bytes" if limit_kind else "")
    if not 2 + len(number_names) <= len(args) <= 3 + len(number_names):
        raise UsageError("")
    limit, *window = [_parse_positive(text, name) for text, name in zip(args[2:], number_names, strict=False)]
    source, target = input_and_output([args[1], *args[2 + len(number_names) :]], "throttle")
    with open_node_for(invocation, source, "throttle") as node:
        lazy, uses_wall_time = (bool_param(node, name) for name in ("lazy", "wall_clock"))
        latch = bool_param(node, "force_latch") if "~force_latch" in node.params else None
        now = time.time_ns if uses_wall_time else lambda: node.now().to_nsec()

        def on_time_jump() -> None:
            node.log.warn("time jumped back: throttling was reset")

        gate: MessageThrottle | ByteThrottle
        if window:
            gate = ByteThrottle(int(limit), round(window[0] * 1e9), now, on_time_jump)
            description = f"less than {limit:g} bytes in {window[0]:g} s"
        else:
            gate = MessageThrottle(round(1e9 / limit), now, on_time_jump)
            description = f"at most {limit:g} messages per second"
        relay, _output = make_relay(node, source, target, gate, latch)
        node.log.info("throttle from %s to %s: %s", source, target, description)
        if lazy:
            relay.run_lazy()
        else:
            relay.run()


VERB = Tool(
    "throttle",
    "republish a topic with a limit on messages or bytes per second (default: as IN_TOPIC_throttle)",
    Argument("messages|bytes", "throttle_unit"),
    Argument("IN_TOPIC", "topic"),
    usage=(
        "messages IN_TOPIC MSGS_PER_SEC [OUT_TOPIC]\n       throttle bytes IN_TOPIC BYTES_PER_SEC WINDOW [OUT_TOPIC]"
    ),
    parameters=[
        LAZY_HELP,
        "_wall_clock:=true  use wall time instead of simulated time",
        "_force_latch:=true (or false) whether to latch the output, regardless of the input",
    ],
    examples=[
        ("messages /scan 2", "publish at most two messages per second on /scan_throttle"),
        ("bytes /image 1000000 1", "publish less than one megabyte per second on /image_throttle"),
    ],
    run=run,
)


def _parse_positive(text: str, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"{name} must be a number, not {text!r}") from None
    if not 0 < value < math.inf:
        raise UsageError(f"{name} must be greater than 0, not {text}")
    return value
