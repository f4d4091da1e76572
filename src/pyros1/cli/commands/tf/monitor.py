"""``tf monitor``: the delays and rates of transforms (L196)."""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.tf._node import LookupHints, make_pause, open_node, wait_for_clock
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.tf.buffer import Buffer

_WINDOW = 1000
"""Number of transforms per frame, and of messages per node, that averages include."""

_STEP = 0.01
_STEPS = 21
"""Number of checks of the chain between two reports."""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print reports until the command is interrupted."""
    if len(args) not in (0, 2):
        raise UsageError("give two frames, or none for all frames")
    with open_node(invocation, "tf_monitor") as node:
        _monitor(invocation, node, [name.removeprefix("/") for name in args])


VERB = Verb(
    "monitor",
    "print the delays and rates of transforms",
    Argument("frame_a", "frame", optional=True),
    Argument("frame_b", "frame", optional=True),
    usage="[frame_a frame_b]",
    examples=[
        ("", "all frames and the nodes that publish them"),
        ("map base_link", "the frames between two frames, and the age of the transform"),
    ],
    aliases=["tf_monitor"],
    stock="rosrun tf tf_monitor",
    run=run,
)


class Delays:
    """Records the delays of each frame's transforms and of each node's messages, in seconds."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._frames: dict[str, deque[float]] = {}
        self._nodes: dict[str, deque[float]] = {}
        self._times: dict[str, deque[float]] = {}
        self._senders: dict[str, str] = {}

    def add_transforms(self, frames: list[tuple[str, float]], sender: str, now: float) -> None:
        """Record a message: each frame with its stamp in seconds, 0 for a static transform."""
        lag = [(name, now - stamp if stamp else 0.0) for name, stamp in frames]
        with self._lock:
            for name, delay in lag:
                self._senders[name] = sender
                self._frames.setdefault(name, deque(maxlen=_WINDOW)).append(delay)
            average = sum(delay for _, delay in lag) / max(1, len(lag))
            self._nodes.setdefault(sender, deque(maxlen=_WINDOW)).append(average)
            self._times.setdefault(sender, deque(maxlen=_WINDOW)).append(now)

    def lines(self, chain: list[str] | None) -> list[str]:
        """Return the report about the frames of a chain (None means all frames) and about all nodes."""
        with self._lock:
            rows = ["", "Frames:"]
            for name, delays in sorted(self._frames.items()):
                if chain is None or name in chain:
                    rows.append(f"Frame: {name} published by {self._senders[name]} {_delays(delays)}")
            rows += ["", "All Broadcasters:"]
            for name, delays in sorted(self._nodes.items()):
                times = self._times[name]
                rate = len(times) / max(1e-8, times[-1] - times[0])
                rows.append(f"Node: {name} {rate:g} Hz, {_delays(delays)}")
            return rows


def _delays(delays: deque[float]) -> str:
    return f"Average Delay: {sum(delays) / len(delays):g} Max Delay: {max(0.0, *delays):g}"


def _monitor(invocation: Invocation, node: Node, frames: list[str]) -> None:
    from pyros1.tf.buffer import Buffer  # noqa: PLC0415 - not needed for wrong arguments
    from pyros1.tf.listener import TransformListener  # noqa: PLC0415

    delays = Delays()
    buffer = Buffer()
    listener = TransformListener(node, buffer)
    hints = LookupHints(invocation, node, buffer)
    wait_for_clock(node)
    chain = _wait_for_chain(node, buffer, hints, *frames) if frames else None

    def add_transforms(message: Any, static: bool) -> None:
        sender = (message._connection_header or {}).get("callerid", "unknown_publisher")
        stamps = [(item.child_frame_id, 0.0 if static else item.header.stamp.to_sec()) for item in message.transforms]
        delays.add_transforms(stamps, f"{sender}(static)" if static else sender, node.now().to_sec())

    kind = "tf2_msgs/TFMessage"
    with (
        listener,
        node.subscribe("/tf", kind, lambda message: add_transforms(message, False), queue_size=100),
        node.subscribe("/tf_static", kind, lambda message: add_transforms(message, True), queue_size=100),
    ):
        average = longest_delay = 0.0
        pause = make_pause(node)
        step = 0
        while pause(_STEP):
            step += 1
            if chain and buffer.can_transform(*frames):
                stamp = buffer.get_latest_common_time(*frames).to_sec()
                lag = node.now().to_sec() - stamp if stamp else 0.0
                average = 0.01 * lag + 0.99 * average
                longest_delay = max(longest_delay, lag)
            if step % _STEPS:
                continue
            if not buffer.frames():
                hints.print_hint(None)
                continue
            rows = ["", "", "", f"RESULTS: for {' to '.join(frames) or 'all Frames'}"]
            if chain:
                rows += [f"Chain is: {' -> '.join(chain)}", f"Net delay     avg = {average:g}: max = {longest_delay:g}"]
            print(*map(one_line, rows + delays.lines(chain)), sep="\n", flush=True)


def _wait_for_chain(node: Node, buffer: Buffer, hints: LookupHints, first: str, last: str) -> list[str]:
    print(f"Waiting for transform chain to become available between {first} and {last} ", end="", flush=True)
    while not buffer.can_transform(first, last, timeout=1.0):
        print(".", end="", flush=True)
        hints.print_hint(None, first, last)
    print(flush=True)
    return buffer.chain(last, first)
