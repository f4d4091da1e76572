"""``tf monitor``: prints the delays and rates of transforms (L196)."""

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

_WINDOW_SIZE = 1000
"""Number of transforms per frame, and of messages per node, over which averages are computed."""

_CHECK_PERIOD = 0.01
_CHECKS_PER_REPORT = 21
"""Number of times that the chain is checked per report."""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print reports on the delays and rates of transforms until the command is interrupted."""
    if len(args) not in (0, 2):
        raise UsageError("give two frames, or none for all frames")
    with open_node(invocation, "tf_monitor") as node:
        _print_reports(invocation, node, [name.removeprefix("/") for name in args])


VERB = Verb(
    "monitor",
    "print the delays and rates of transforms",
    Argument("frame_a", "frame", optional=True),
    Argument("frame_b", "frame", optional=True),
    usage="[frame_a frame_b]",
    examples=[
        ("", "print all frames and the nodes that publish them"),
        ("map base_link", "print the frames between two frames and the age of the transform"),
    ],
    aliases=["tf_monitor"],
    stock="rosrun tf tf_monitor",
    run=run,
)


class Delays:
    """Records the delays of each frame's transforms and of each node's messages, in seconds."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._delays_by_frame: dict[str, deque[float]] = {}
        self._delays_by_node: dict[str, deque[float]] = {}
        self._times_by_node: dict[str, deque[float]] = {}
        self._sender_by_frame: dict[str, str] = {}

    def add_transforms(self, frames: list[tuple[str, float]], sender: str, now: float) -> None:
        """Record the transforms in a message.

        Args:
            frames: the child frame and the stamp in seconds of each transform, with stamp 0 for static transforms.
            sender: the node that published the message.
            now: the current time in seconds.
        """
        delays = [(name, now - stamp if stamp else 0.0) for name, stamp in frames]
        with self._lock:
            for name, delay in delays:
                self._sender_by_frame[name] = sender
                self._delays_by_frame.setdefault(name, deque(maxlen=_WINDOW_SIZE)).append(delay)
            average = sum(delay for _, delay in delays) / max(1, len(delays))
            self._delays_by_node.setdefault(sender, deque(maxlen=_WINDOW_SIZE)).append(average)
            self._times_by_node.setdefault(sender, deque(maxlen=_WINDOW_SIZE)).append(now)

    def lines(self, chain: list[str] | None) -> list[str]:
        """Return the lines of the report on the frames in `chain`, or on all frames if it is None, and on all nodes."""
        with self._lock:
            rows = ["", "Frames:"]
            for name, delays in sorted(self._delays_by_frame.items()):
                if chain is None or name in chain:
                    rows.append(f"Frame: {name} published by {self._sender_by_frame[name]} {_delay_summary(delays)}")
            rows += ["", "All Broadcasters:"]
            for name, delays in sorted(self._delays_by_node.items()):
                times = self._times_by_node[name]
                rate = len(times) / max(1e-8, times[-1] - times[0])
                rows.append(f"Node: {name} {rate:g} Hz, {_delay_summary(delays)}")
            return rows


def _delay_summary(delays: deque[float]) -> str:
    return f"Average Delay: {sum(delays) / len(delays):g} Max Delay: {max(0.0, *delays):g}"


def _print_reports(invocation: Invocation, node: Node, frames: list[str]) -> None:
    from pyros1.tf.buffer import Buffer  # noqa: PLC0415 - not needed for invalid arguments
    from pyros1.tf.listener import TransformListener  # noqa: PLC0415

    delays = Delays()
    buffer = Buffer()
    listener = TransformListener(node, buffer)
    hints = LookupHints(invocation, node, buffer)
    wait_for_clock(node)
    chain = _wait_for_chain(node, buffer, hints, *frames) if frames else None

    def add_transforms(message: Any, static: bool) -> None:
        sender = (message._connection_header or {}).get("callerid", "unknown_publisher")
        stamps = [
            (transform.child_frame_id, 0.0 if static else transform.header.stamp.to_sec())
            for transform in message.transforms
        ]
        delays.add_transforms(stamps, f"{sender}(static)" if static else sender, node.now().to_sec())

    type_name = "tf2_msgs/TFMessage"
    with (
        listener,
        node.subscribe("/tf", type_name, lambda message: add_transforms(message, False), queue_size=100),
        node.subscribe("/tf_static", type_name, lambda message: add_transforms(message, True), queue_size=100),
    ):
        average_delay = longest_delay = 0.0
        pause = make_pause(node)
        check_count = 0
        while pause(_CHECK_PERIOD):
            check_count += 1
            if chain and buffer.can_transform(*frames):
                stamp = buffer.get_latest_common_time(*frames).to_sec()
                delay = node.now().to_sec() - stamp if stamp else 0.0
                average_delay = 0.01 * delay + 0.99 * average_delay
                longest_delay = max(longest_delay, delay)
            if check_count % _CHECKS_PER_REPORT:
                continue
            if not buffer.frames():
                hints.print_hint(None)
                continue
            rows = ["", "", "", f"RESULTS: for {' to '.join(frames) or 'all Frames'}"]
            if chain:
                rows += [
                    f"Chain is: {' -> '.join(chain)}",
                    f"Net delay     avg = {average_delay:g}: max = {longest_delay:g}",
                ]
            print(*map(one_line, rows + delays.lines(chain)), sep="\n", flush=True)


def _wait_for_chain(node: Node, buffer: Buffer, hints: LookupHints, first: str, last: str) -> list[str]:
    print(f"Waiting for transform chain to become available between {first} and {last} ", end="", flush=True)
    while not buffer.can_transform(first, last, timeout=1.0):
        print(".", end="", flush=True)
        hints.print_hint(None, first, last)
    print(flush=True)
    return buffer.chain(last, first)
