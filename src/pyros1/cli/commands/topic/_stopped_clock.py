"""Warns users if simulated time does not advance, for verbs that measure simulated time."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from pyros1.ground.timing import Time

if TYPE_CHECKING:
    from pyros1.node import Node


class StoppedClockDetector:
    """Detects that simulated time does not advance. Call `warn_if_stopped` periodically.

    Args:
        node: the command's node.
        hint: a hint for the user, appended to the warning.
    """

    def __init__(self, node: Node, hint: str = "") -> None:
        self._node = node
        self._hint = hint
        self._uses_simulated_time = node.params.get("/use_sim_time", False) is True
        self._last_time: Time | None = None
        self._has_warned = False

    def warn_if_stopped(self) -> bool:
        """Warn once whenever simulated time stops. Return whether the time is the same as in the last call."""
        if not self._uses_simulated_time:
            return False
        now = self._node.now()
        previous, self._last_time = self._last_time, now
        if now != previous:
            self._has_warned = False
            return False
        if not self._has_warned:
            self._has_warned = True
            message = (
                f"WARNING: simulated time has stopped at {now.to_sec():.3f} s. Is /clock being published?{self._hint}"
            )
            print(message, file=sys.stderr, flush=True)
        return True
