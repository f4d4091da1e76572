"""Runs a robot node until it is shut down."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic, sleep
from typing import Any

from pyros1.ground.errors import Error, NodeShutdownError
from pyros1.node import Node

CLOCK_PATIENCE = 5.0
"""Seconds to wait for simulated time before a warning is logged."""
_POLL_PERIOD = 0.1


def run_node(argv: list[str], name: str, start: Callable[[Node], object], **options: Any) -> int:
    """Run a node until it is shut down; return its exit code.

    Args:
        argv: the command line, with the program's name.
        name: the node's name, unless the command line sets another one.
        start: creates the node's publishers, subscribers, services and timers. Its result is kept until the node ends.
            If it raises an `Error`, this is logged, and the exit code is 1.
        options: other arguments of `Node`, such as ``anonymous``.
    """
    with Node(name, argv=argv[1:], **options) as node:
        try:
            running = start(node)
        except NodeShutdownError:  # Ctrl-C came before the node was complete
            return 0
        except Error as error:
            node.log.fatal("%s", error)
            return 1
        if node.simulated_time:
            _wait_for_clock(node)
        node.spin()
        del running
    return 0


def _wait_for_clock(node: Node) -> None:
    """Log a warning if simulated time does not start, since the node's timers then do not work."""
    deadline = monotonic() + CLOCK_PATIENCE
    while node.ok() and not node.now().to_sec():
        if monotonic() >= deadline:
            node.log.warn(
                "/use_sim_time is true, but nobody publishes /clock, so time stands still: "
                "start the simulation, or set it to false and restart this node"
            )
            return
        node.spin_once()
        sleep(_POLL_PERIOD)
