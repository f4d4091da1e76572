"""Decides which of several sources of velocity commands drives the robot."""

from __future__ import annotations

from collections.abc import Sequence

from pyros1.robot_nodes.shared.twist_sources import Source


class Arbiter:
    """Decides for each command whether to pass it on.

    A topic is masked before its first command, while its last command is older than its timeout, and while a lock of
    higher priority is on. A command is passed on unless another topic that is not masked has a higher priority, or has
    the same and comes earlier in the list. As in stock ROS, a topic of priority 0 never drives. A lock is on if its
    last message is True or older than its timeout, or if there was none. With a timeout of 0, messages never expire,
    and a lock without messages is off. Times are in seconds; if time jumps back, earlier messages count as expired.

    Args:
        topics: the topics with commands.
        locks: the locks.

    Attributes:
        driver: the index of the topic whose command was passed on last; None if the robot has been stopped since.
    """

    def __init__(self, topics: Sequence[Source], locks: Sequence[Source]) -> None:
        self.topics, self.locks = tuple(topics), tuple(locks)
        self.driver: int | None = None
        self._received: list[float | None] = [None] * len(topics)
        self._locked: list[tuple[float, bool] | None] = [None] * len(locks)

    def command(self, topic: int, now: float) -> bool:
        """Handle a command on a topic; return whether to pass it on."""
        self._received[topic] = now
        if self._selected(now) != topic:
            return False
        self.driver = topic
        return True

    def lock(self, lock: int, is_on: bool, now: float) -> None:
        """Handle a message on a lock's topic."""
        self._locked[lock] = (now, is_on)

    def must_stop(self, now: float) -> bool:
        """Return True, once, when the topic that drives the robot is masked, so that the robot must be stopped."""
        if self.driver is None or not self.is_masked(self.driver, now):
            return False
        self.driver = None
        return True

    def is_locked(self, lock: int, now: float) -> bool:
        """Return whether a lock is on."""
        message, timeout = self._locked[lock], self.locks[lock].timeout
        if message is None:
            return timeout > 0
        time, is_on = message
        return is_on or _is_old(time, timeout, now)

    def locked_priority(self, now: float) -> int:
        """Return the priority below which topics are locked."""
        return max((lock.priority for index, lock in enumerate(self.locks) if self.is_locked(index, now)), default=0)

    def is_masked(self, topic: int, now: float) -> bool:
        """Return whether commands on a topic cannot be passed on."""
        received, entry = self._received[topic], self.topics[topic]
        return received is None or _is_old(received, entry.timeout, now) or entry.priority < self.locked_priority(now)

    def _selected(self, now: float) -> int | None:
        best, priority = None, 0
        for index, topic in enumerate(self.topics):
            if topic.priority > priority and not self.is_masked(index, now):
                best, priority = index, topic.priority
        return best

    def age(self, now: float) -> float:
        """Return the age of the last command in seconds; 0 before the first one."""
        times = [time for time in self._received if time is not None]
        return max(0.0, now - max(times)) if times else 0.0


def _is_old(time: float, timeout: float, now: float) -> bool:
    return timeout > 0 and not 0 <= now - time <= timeout
