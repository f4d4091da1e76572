"""``topic_tools throttle`` (L189)."""

from __future__ import annotations

import math
import time
from typing import Any

from pyros1.cli.commands.topic_tools._tool import LAZY, Tool, flag, make_relay, open_node_for, topics
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Republish a topic at a limited rate, until the node ends."""
    from pyros1.topic_tools.gates import ByteThrottle, MessageThrottle  # noqa: PLC0415

    kind = args[0] if args else ""
    numbers = {"messages": ["MSGS_PER_SEC"], "bytes": ["BYTES_PER_SEC", "WINDOW"]}.get(kind)
    if numbers is None:
        raise UsageError(f"unknown limit {kind!r}: use messages or bytes" if kind else "")
    if not 2 + len(numbers) <= len(args) <= 3 + len(numbers):
        raise UsageError("")
    limit, *window = [_positive(text, name) for text, name in zip(args[2:], numbers, strict=False)]
    source, target = topics([args[1], *args[2 + len(numbers) :]], "throttle")
    with open_node_for(invocation, source, "throttle") as node:
        lazy, wall = (flag(node, name) for name in ("lazy", "wall_clock"))
        latch = flag(node, "force_latch") if "~force_latch" in node.params else None
        now = time.time_ns if wall else lambda: node.now().to_nsec()

        def jumped() -> None:
            node.log.warn("time jumped back: throttling starts again")

        gate: MessageThrottle | ByteThrottle
        if window:
            gate = ByteThrottle(int(limit), round(window[0] * 1e9), now, jumped)
            description = f"less than {limit:g} bytes in {window[0]:g} s"
        else:
            gate = MessageThrottle(round(1e9 / limit), now, jumped)
            description = f"at most {limit:g} messages per second"
        relay, _output = make_relay(node, source, target, gate, latch)
        node.log.info("throttle from %s to %s: %s", source, target, description)
        if lazy:
            relay.run_lazy()
        else:
            relay.run()


VERB = Tool(
    "throttle",
    "republish a topic with a limit on messages per second, or on bytes per second (default: as IN_TOPIC_throttle)",
    Argument("messages|bytes", "throttle"),
    Argument("IN_TOPIC", "topic"),
    usage=(
        "messages IN_TOPIC MSGS_PER_SEC [OUT_TOPIC]\n       throttle bytes IN_TOPIC BYTES_PER_SEC WINDOW [OUT_TOPIC]"
    ),
    parameters=[
        LAZY,
        "_wall_clock:=true  do not measure simulated time",
        "_force_latch:=true (or false) latch the output or not, whatever the input does",
    ],
    examples=[
        ("messages /scan 2", "/scan_throttle: two messages a second"),
        ("bytes /image 1000000 1", "/image_throttle: less than a megabyte a second"),
    ],
    run=run,
)


def _positive(text: str, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"{name} must be a number, not {text!r}") from None
    if not 0 < value < math.inf:
        raise UsageError(f"{name} must be greater than 0, not {text}")
    return value
