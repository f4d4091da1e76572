"""Sorts diagnostics into a tree with the configured analyzers (no I/O)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus
from pyros1.robot_nodes.diagnostic_aggregator.analyzers import AnalyzerGroup, OtherAnalyzer, combine


class Aggregator:
    """The configured analyzers, and one for the items that match none of them.

    Args:
        group: the analyzers.
        base_path: the parent path of the items that match none.
        other_as_errors: whether such items are errors.
        now: the time in seconds.
    """

    def __init__(self, group: AnalyzerGroup, base_path: str, other_as_errors: bool, now: float) -> None:
        self.group = group
        self._other = OtherAnalyzer(base_path, now, other_as_errors)

    def add(self, group: AnalyzerGroup) -> None:
        """Add analyzers."""
        self.group.analyzers.append(group)

    def remove(self, group: AnalyzerGroup) -> None:
        """Remove analyzers that `add` added, unless they have been removed."""
        if group in self.group.analyzers:
            self.group.analyzers.remove(group)

    def receive(self, statuses: Iterable[Any], now: float) -> None:
        """Process the statuses in a message on /diagnostics."""
        for status in statuses:
            if not self.group.analyze(status, now):
                self._other.analyze(status, now)

    def report(self, now: float) -> tuple[list[DiagnosticStatus], DiagnosticStatus]:
        """Return all statuses in the tree, and one that summarizes them."""
        statuses = [*self.group.report(now), *self._other.report(now)]
        level = combine(status.level for status in statuses)
        return statuses, DiagnosticStatus(level=level, name="toplevel_state")
