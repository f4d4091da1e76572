"""Finds the magnetic field that belongs to an IMU message; the two arrive on different topics."""

from __future__ import annotations

from typing import Any

from pyros1.filters.synchronizers import ApproximateTime
from pyros1.ground.timing import Duration, Time
from pyros1.robot_nodes.shared.imu_readings import MAX_PAUSE

SLOP = 0.5
"""Maximum number of seconds between the stamps of an IMU message and its magnetic field. Stock has no limit."""


class ImuPairs:
    """Finds pairs of messages with nearly equal stamps, even if stamps jump back, as when a bag is played in a loop.

    Args:
        queue_size: maximum number of waiting messages per topic.
    """

    def __init__(self, queue_size: int) -> None:
        self._matcher = ApproximateTime(2, queue_size, SLOP)
        self._newest = [Time(), Time()]

    def add(self, index: int, stamp: Time, message: Any) -> list[tuple[Any, ...]]:
        """Add a message; return the pairs that it completes, each an IMU message and its field.

        Args:
            index: 0 for an IMU message, 1 for a magnetic field.
            stamp: the message's time stamp.
            message: the message.
        """
        if self._newest[index] - stamp > Duration.from_sec(MAX_PAUSE):
            # Only clear this topic's queue: the other topic may have jumped earlier, and may wait for this message.
            self._matcher.queues[index].clear()
        self._newest[index] = stamp
        return self._matcher.add(index, stamp, message)
