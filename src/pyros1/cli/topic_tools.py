"""``pyros1 topic_tools``: the tools of the ROS package topic_tools, as commands and as nodes (L187-L194).

The package ``topic_tools`` of `pyros1.packages` has a script for each, which comes here, too.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pyros1 import names
from pyros1.cli.common import EX_USAGE, CommandError, did_you_mean
from pyros1.cli.topic_tools_usage import ABOUT, help_text, usage_line

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.topic_tools.output import Output


class UsageError(CommandError):
    """The command line is wrong; the text says how, and may be empty."""


def main(argv: list[str]) -> int:
    """Run a tool.

    Args:
        argv: the tool's name and its arguments, remappings among them.

    Returns:
        The exit code: 1 after wrong usage of a tool, 64 if there is no such tool.
    """
    tool, words = (argv[0], argv[1:]) if argv else ("", [])
    if tool not in ABOUT:
        print(help_text(""))
        hint = did_you_mean(tool, ABOUT)
        if tool in ("-h", "--help"):
            return 0
        if tool:
            print(f"pyros1 topic_tools: there is no {tool!r}{hint}", file=sys.stderr)
        return EX_USAGE
    try:
        return _run(tool, words)
    except UsageError as error:
        if str(error):
            print(f"{tool}: {error}", file=sys.stderr)
        print(f"\n{usage_line(tool)}\n")
        return error.code
    except CommandError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return error.code


def _run(tool: str, words: list[str]) -> int:
    if tool in ("transform", "relay_field"):
        from pyros1.cli.topic_tools_transform import main as transform  # noqa: PLC0415 - the others need no expressions

        return transform(tool, words)
    arguments = names.parse_arguments(words).rest
    if "-h" in arguments or "--help" in arguments:
        print(help_text(tool))
        return 0
    if tool in _TOOLS:
        _TOOLS[tool](arguments, words)
        return 0
    from pyros1.cli.topic_tools_select import main as select  # noqa: PLC0415

    return select(tool, arguments, words)


def open_node(base: str, words: Sequence[str]) -> Node:
    """Return a node of that name, made unique."""
    from pyros1.node import Node  # noqa: PLC0415 - help needs none

    if not names.is_legal_base_name(base):
        raise UsageError(f"{base!r} cannot be a node's name")
    return Node(base, anonymous=True, argv=words, environ=os.environ)


def _relay(arguments: list[str], words: list[str]) -> None:
    source, target = _topics(arguments, 1, 2, "_relay")
    with _node_for(source, "relay", words) as node:
        lazy, stealth = (_flag(node, name) for name in ("lazy", "stealth"))
        monitor = str(node.params.get("~monitor_topic", target))
        rate = _number(node, "monitor_rate", 1.0)
        relay, _output = _make_relay(node, source, target)
        node.log.info("relay from %s to %s%s", source, target, ", stealthy" if stealth else ", lazy" if lazy else "")
        if stealth:
            relay.run_stealth(monitor, 1.0 / rate)
        elif lazy:
            relay.run_lazy()
        else:
            relay.run()


def _drop(arguments: list[str], words: list[str]) -> None:
    from pyros1.topic_tools.drop import Drop  # noqa: PLC0415

    if len(arguments) not in (3, 4):
        raise UsageError("")
    dropped, among = _integer(arguments[1], "X", 0), _integer(arguments[2], "Y", 1)
    source, target = _topics([arguments[0], *arguments[3:]], 1, 2, "_drop")
    with _node_for(source, "drop", words) as node:
        relay, _output = _make_relay(node, source, target, Drop(dropped, among), latch=False)
        node.log.info("drop %d of every %d messages from %s to %s", dropped, among, source, target)
        relay.run()


def _throttle(arguments: list[str], words: list[str]) -> None:
    from pyros1.topic_tools.throttle import ByteThrottle, MessageThrottle  # noqa: PLC0415

    kind = arguments[0] if arguments else ""
    numbers = {"messages": ["MSGS_PER_SEC"], "bytes": ["BYTES_PER_SEC", "WINDOW"]}.get(kind)
    if numbers is None:
        raise UsageError(f"there is messages and bytes, not {kind!r}" if kind else "")
    if not 2 + len(numbers) <= len(arguments) <= 3 + len(numbers):
        raise UsageError("")
    most, *window = [_positive(text, name) for text, name in zip(arguments[2:], numbers, strict=False)]
    source, target = _topics([arguments[1], *arguments[2 + len(numbers) :]], 1, 2, "_throttle")
    with _node_for(source, "throttle", words) as node:
        lazy, wall = (_flag(node, name) for name in ("lazy", "wall_clock"))
        latch = _flag(node, "force_latch") if "~force_latch" in node.params else None
        now = time.time_ns if wall else lambda: node.now().to_nsec()

        def jumped() -> None:
            node.log.warn("time jumped back: throttling begins anew")

        gate: MessageThrottle | ByteThrottle
        if window:
            gate = ByteThrottle(int(most), round(window[0] * 1e9), now, jumped)
            said = f"less than {most:g} bytes in {window[0]:g} s"
        else:
            gate = MessageThrottle(round(1e9 / most), now, jumped)
            said = f"at most {most:g} messages per second"
        relay, _output = _make_relay(node, source, target, gate, latch)
        node.log.info("throttle from %s to %s: %s", source, target, said)
        if lazy:
            relay.run_lazy()
        else:
            relay.run()


def _mux(arguments: list[str], words: list[str]) -> None:
    from pyros1.topic_tools.mux import Mux  # noqa: PLC0415

    if len(arguments) < 2:
        raise UsageError("")
    target, *sources = arguments
    with _node_for(target, "mux", words) as node:
        lazy, latch, wait = (_flag(node, name) for name in ("lazy", "latch", "wait_publisher_initialization"))
        patience = _number(node, "wait_publisher_second", 0.1) if wait else 0.0
        initial = str(node.params.get("~initial_topic", ""))
        node.log.info("mux from %s to %s", ", ".join(sources), target)
        Mux(node, target, sources, initial, lazy, latch, patience).run()


def _demux(arguments: list[str], words: list[str]) -> None:
    from pyros1.topic_tools.demux import Demux  # noqa: PLC0415

    if len(arguments) < 2:
        raise UsageError("")
    source, *targets = arguments
    with _node_for(source, "demux", words) as node:
        node.log.info("demux from %s to %s", source, ", ".join(targets))
        Demux(node, source, targets).run()


_TOOLS: Mapping[str, Callable[[list[str], list[str]], None]] = {
    "relay": _relay,
    "drop": _drop,
    "throttle": _throttle,
    "mux": _mux,
    "demux": _demux,
}


def _node_for(topic: str, tool: str, words: list[str]) -> Node:
    from pyros1.topic_tools.output import base_name  # noqa: PLC0415

    return open_node(f"{base_name(topic)}_{tool}", words)


def _make_relay(
    node: Node, source: str, target: str, gate: Any = None, latch: bool | None = None
) -> tuple[Any, Output]:
    from pyros1.topic_tools.output import Output  # noqa: PLC0415
    from pyros1.topic_tools.relay import Relay  # noqa: PLC0415

    transports = ("udp", "tcp") if _flag(node, "unreliable") else ("tcp",)
    output = Output(node, target, latch)
    return Relay(node, source, output, gate, transports), output


# Arguments and parameters ---------------------------------------------------------------------------------------------


def _topics(arguments: list[str], least: int, most: int, suffix: str) -> tuple[str, str]:
    """Input and output; the output's name is made from the input's if it is not given."""
    if not least <= len(arguments) <= most:
        raise UsageError("")
    return arguments[0], arguments[1] if len(arguments) > 1 else arguments[0] + suffix


def _integer(text: str, name: str, least: int) -> int:
    try:
        value = int(text)
    except ValueError:
        raise UsageError(f"{name} must be a whole number, not {text!r}") from None
    if value < least:
        raise UsageError(f"{name} must be at least {least}, not {value}")
    return value


def _positive(text: str, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"{name} must be a number, not {text!r}") from None
    if not 0 < value < math.inf:
        raise UsageError(f"{name} must be greater than 0, not {text}")
    return value


def _flag(node: Node, name: str) -> bool:
    value = node.params.get(f"~{name}", False)
    if value not in (True, False):
        raise CommandError(f"the parameter ~{name} must be true or false, not {value!r}")
    return bool(value)


def _number(node: Node, name: str, default: float) -> float:
    value = node.params.get(f"~{name}", default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < math.inf:
        raise CommandError(f"the parameter ~{name} must be a number greater than 0, not {value!r}")
    return value
