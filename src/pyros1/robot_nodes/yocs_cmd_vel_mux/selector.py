"""Decides which of several sources of velocity commands drives the robot."""

from __future__ import annotations

from collections.abc import Sequence

from pyros1.robot_nodes.shared.twist_sources import Source

IDLE = "idle"
"""The name of the active source while there is none."""


class Selector:
    """Decides for each command whether to pass it on.

    A source drives the robot until it has sent nothing for its timeout, or until a source of higher priority sends
    a command. Times are in seconds; if time jumps back, earlier commands count as too old.

    Args:
        sources: the sources.
    """

    def __init__(self, sources: Sequence[Source]) -> None:
        self._sources = tuple(sources)
        self._allowed: int | None = None
        self._received = 0.0

    @property
    def active(self) -> str:
        """The name of the source that drives the robot, or `IDLE`."""
        return IDLE if self._allowed is None else self._sources[self._allowed].name

    def command(self, source: int, now: float) -> bool:
        """Handle a command from a source; return whether to pass it on."""
        self.must_stop(now)
        allowed = self._allowed
        if allowed not in (None, source) and self._sources[source].priority <= self._sources[allowed].priority:
            return False
        self._allowed, self._received = source, now
        return True

    def must_stop(self, now: float) -> bool:
        """Return True, once, when the source that drives the robot is silent, so that the robot must be stopped."""
        if self._allowed is None or 0 <= now - self._received < self._sources[self._allowed].timeout:
            return False
        self._allowed = None
        return True
