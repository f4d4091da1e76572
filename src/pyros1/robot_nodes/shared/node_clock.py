"""The clock for timeouts of nodes, and the timer for checking them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.node import Node


def seconds(node: Node) -> float:
    """Return the time in seconds, for measuring how long something has been going on.

    It is simulated time if the node uses that and somebody publishes it, else monotonic time, which does not jump when
    the system's clock is set. At the first message on /clock, it jumps.
    """
    return (node.now().to_sec() if node.simulated_time else 0.0) or monotonic()


def check_regularly(node: Node, period: float, check: Callable[[], object]) -> None:
    """Call a function that may have to stop a robot, until the node shuts down.

    If time is simulated, the function is called by wall time, too: timers stand still if nobody publishes /clock, and a
    robot whose /use_sim_time was left on must be stopped nevertheless.

    Args:
        node: the node.
        period: seconds between calls.
        check: the function; calls from several threads must do no harm.
    """
    node.timer(period, lambda event: check())
    if not node.simulated_time:
        return
    ended = threading.Event()

    def run() -> None:
        while not ended.wait(period):
            check()

    def end() -> None:
        ended.set()
        thread.join(1.0)

    thread = threading.Thread(target=run, name=f"{node.name}:checks", daemon=True)
    thread.start()
    node.on_shutdown(end)
