"""The clock for timeouts of nodes."""

from __future__ import annotations

from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.node import Node


def seconds(node: Node) -> float:
    """Return the time in seconds, for measuring how long something has been going on.

    It is simulated time if the node uses that, else monotonic time, which does not jump when the system's clock is set.
    """
    return node.now().to_sec() if node.simulated_time else monotonic()
