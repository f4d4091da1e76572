"""A warning when simulated time stands still, for verbs that use it for measurements."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from pyros1.ground.timing import Time

if TYPE_CHECKING:
    from pyros1.node import Node


class StoppedClock:
    """Checks from time to time whether simulated time advances.

    Args:
        node: the command's node.
        hint: what the user may do about it.
    """

    def __init__(self, node: Node, hint: str = "") -> None:
        self._node = node
        self._hint = hint
        self._simulated = node.params.get("/use_sim_time", False) is True
        self._last: Time | None = None
        self._warned = False

    def has_stopped(self) -> bool:
        """Return whether time has not moved since the last call; warn, once until it moves."""
        if not self._simulated:
            return False
        now = self._node.now()
        before, self._last = self._last, now
        if now != before:
            self._warned = False
            return False
        if not self._warned:
            self._warned = True
            text = (
                f"WARNING: simulated time stands still at {now.to_sec():.3f} s. Is /clock being published?{self._hint}"
            )
            print(text, file=sys.stderr, flush=True)
        return True
