"""Decides what a bridge logs about its connections: that there are none, or that one has no permissions. No I/O."""

from __future__ import annotations

from collections.abc import Collection

from pyros1.bridge.exchange.actions import Log
from pyros1.bridge.transport.connections import Connections
from pyros1.bridge.transport.link import Link

PATIENCE = 5.0
"""Seconds without a connection before this is logged: bridges rarely start at the same moment."""


class LinkReport:
    """Decides what to log about a link.

    Args:
        link: the link.
        allowed: the certificate names that have any permissions; empty for all.
        whom: what the link connects to, for the log.
    """

    def __init__(self, link: Link, allowed: Collection[str], whom: str = "other sites") -> None:
        self._link = link
        self._whom = whom
        self._connections = Connections(allowed)
        self._since: float | None = None
        self._logged = ""

    def update(self, now: float) -> list[Log]:
        """Return the lines to log now. Call this about once per second."""
        lines = [
            Log(event.text, is_warning=True)
            for event in self._connections.update(self._link.connections())
            if event.is_warning
        ]
        problem = self._link.problem
        if not problem:
            if self._logged:
                lines.append(Log(f"connected to {self._whom}"))
            self._since, self._logged = None, ""
        else:
            self._since = now if self._since is None else self._since
            if now - self._since >= PATIENCE and problem != self._logged:
                self._logged = problem
                lines.append(Log(f"no connection to {self._whom}: {problem}", is_warning=True))
        return lines
