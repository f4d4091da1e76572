"""The clock for nodes' timeouts, and a timer that checks them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.node import Node

PATIENCE = 2.0
"""Seconds that simulated time may stand still before timeouts are measured in real time."""


class NodeClock:
    """Measures time for timeouts: simulated time if the node uses it, otherwise monotonic time.

    If nobody publishes /clock, or if it has stopped for `PATIENCE`, real time is used: otherwise nothing would stop a
    robot if /use_sim_time was left on, or if the played bag has ended. After a longer pause of a simulation, commands
    continue when their sources send the next ones.

    Thread-safe.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._last_time = 0.0  # simulated time
        self._ticked_at = monotonic()  # in real time
        self._added = 0.0  # real time added to simulated time up to its last tick
        self._has_warned = False

    def seconds(self) -> float:
        """Return the time in seconds. It jumps when simulated time starts or jumps, but not when it stops."""
        if not self._node.simulated_time:
            return monotonic()
        with self._lock:
            extra = self._follow()
            time, warns = self._last_time + self._added + extra, extra > 0 < self._last_time and not self._has_warned
            self._has_warned = self._has_warned or warns
        if warns:
            self._node.log.warn("/clock has stopped for %g s: now timeouts count in real time", PATIENCE)
        return time

    def stands_still(self) -> bool:
        """Return whether simulated time has not started, or has stood still for longer than `PATIENCE`."""
        if not self._node.simulated_time:
            return False
        with self._lock:
            return self._follow() > 0

    def _follow(self) -> float:
        """Update from simulated time; return the real seconds, beyond `PATIENCE`, for which it has stood still."""
        now, real = self._node.now().to_sec(), monotonic()
        patience = PATIENCE if self._last_time else 0.0
        extra = max(0.0, real - self._ticked_at - patience)
        if now == self._last_time:
            return extra
        self._added += extra
        self._last_time, self._ticked_at, self._has_warned = now, real, False
        return 0.0


def check_regularly(node: Node, period: float, check: Callable[[], object]) -> None:
    """Call a function regularly until the node shuts down; the function stops a robot if necessary.

    With simulated time, the function is also called in wall time: timers stand still if nobody publishes /clock, but a
    robot must be stopped even if /use_sim_time was left on.

    Args:
        node: the node.
        period: seconds between calls.
        check: the function, which must be thread-safe.
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
