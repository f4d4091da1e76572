"""The package's analyzers: they collect the items that belong to them, and report on them (no I/O).

Reports have the same texts as the original's, since programs may look for them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from pyros1.robot_nodes.diagnostic_aggregator.matching import Matcher, join_path, output_name

OK, WARN, ERROR, STALE = 0, 1, 2, 3
MAX_ITEMS = 10_000
"""Maximum number of items per analyzer; further ones are ignored, with a warning in its report."""
MAX_SIZE = 10_000_000
"""Maximum total size of an analyzer's items, in characters; further ones are ignored, with the same warning."""
DEFAULT_TIMEOUT = 5.0
_LEVEL_WORDS = ("OK", "Warning", "Error", "Stale")
_MISSING = "Missing"
_PAIR_SIZE = 100  # approximate size of a pair of key and value, in addition to its characters


def combine(levels: Iterable[int]) -> int:
    """Return the level of a group, the worst of the given levels; but STALE becomes ERROR unless all are STALE."""
    levels = set(levels)
    worst = max(levels, default=OK)
    return ERROR if worst == STALE and levels != {STALE} else worst


@dataclass
class _Item:
    """The latest status with a certain name in /diagnostics."""

    status: Any
    updated_at: float
    size: int = 0


class Analyzer:
    """Base class of the analyzers.

    Args:
        path: the analyzer's path in the tree, such as "/Sensors/Laser".
        title: the analyzer's name in its parent group.
    """

    def __init__(self, path: str, title: str) -> None:
        self.path = path
        self.title = title

    def analyze(self, status: Any, now: float) -> bool:
        """Process a diagnostic_msgs/DiagnosticStatus, and return whether it belongs to this analyzer."""
        return False

    def report(self, now: float) -> list[DiagnosticStatus]:
        """Return this analyzer's statuses as of ``now``. The one with the analyzer's path summarizes the others."""
        return []


class IgnoreAnalyzer(Analyzer):
    """Matches nothing and reports nothing: switches off an analyzer without removing its parameters."""


class GenericAnalyzer(Analyzer):
    """Collects matching items, and monitors their age and number.

    Args:
        path, title: see `Analyzer`.
        matcher: decides which items belong to it.
        now: the time in seconds.
        removed_prefixes: prefixes to remove from the items' names.
        expected: items that are reported as missing if they do not arrive.
        timeout: age in seconds at which items become stale; 0 or less for no limit.
        num_items: how many items there must be; None for any number.
        discard_stale: whether to remove stale items.
    """

    def __init__(
        self,
        path: str,
        title: str,
        matcher: Matcher,
        now: float,
        *,
        removed_prefixes: Sequence[str] = (),
        expected: Sequence[str] = (),
        timeout: float = DEFAULT_TIMEOUT,
        num_items: int | None = None,
        discard_stale: bool = False,
    ) -> None:
        super().__init__(path, title)
        self._matcher = matcher
        self._removed_prefixes = removed_prefixes
        self._expected = tuple(dict.fromkeys(expected))
        self._timeout = timeout
        self._num_items = num_items
        self._discard_stale = discard_stale and timeout > 0
        self._items = {name: _Item(_missing_status(name), now) for name in self._expected}
        self._size = 0
        self._ignored_at: float | None = None
        self._not_stale_at = now

    def matches(self, name: str) -> bool:
        """Return whether the item with this name belongs to the analyzer."""
        return self._matcher.matches(name)

    def analyze(self, status: Any, now: float) -> bool:
        """Keep a status if it belongs to this analyzer, and return whether it does."""
        if not self.matches(status.name):
            return False
        known = self._items.get(status.name)
        size = _size_of(status)
        new_size = self._size + size - (known.size if known else 0)
        if new_size > MAX_SIZE or (known is None and len(self._items) >= MAX_ITEMS):
            self._ignored_at = now
        else:
            self._items[status.name] = _Item(status, now, size)
            self._size = new_size
        return True

    def report(self, now: float) -> list[DiagnosticStatus]:
        """Return a status that summarizes the items, followed by the items.

        If stale items are discarded, so is the summary once it has been stale for longer than the timeout.
        """
        if self._discard_stale:
            self._items = {name: item for name, item in self._items.items() if not self._is_stale(item, now)}
            self._size = sum(item.size for item in self._items.values())
        items = sorted(self._items.items(), key=lambda entry: entry[0].encode())
        statuses = [self._report_item(item, now) for _, item in items]
        missing = [_missing_status(name) for name in self._expected if name not in self._items]
        level, message = self._sum_up([status.level for status in statuses])
        shows_header = True
        if level != STALE or not self._discard_stale:
            self._not_stale_at = now
        elif not 0 <= now - self._not_stale_at <= self._timeout:
            shows_header = False
        if missing:
            stale = level == STALE and all(status.level == STALE for status in statuses)
            level, amount = (STALE, "All") if stale else (ERROR, "Some")
            message = f"{amount} diagnostics are stale - setting combined level to {'STALE' if stale else 'ERROR'}."
            statuses += [self._report_item(_Item(status, now), now) for status in missing]
        if self.ignored_some(now):
            shows_header, level = True, max(level, WARN)
            message = f"Diagnostics were ignored, since there are more than {MAX_ITEMS} items or {MAX_SIZE} characters"
        if not shows_header:
            return statuses
        values = [(name, item.status.message) for name, item in items] + [(each.name, _MISSING) for each in missing]
        return [make_header(self.path, level, values, message), *statuses]

    def ignored_some(self, now: float) -> bool:
        """Return whether diagnostics were recently ignored because there were too many, or they were too large."""
        return self._ignored_at is not None and 0 <= now - self._ignored_at <= DEFAULT_TIMEOUT

    def _is_stale(self, item: _Item, now: float) -> bool:
        """Return whether an item is too old, or time has jumped back since it arrived."""
        return self._timeout > 0 and not 0 <= now - item.updated_at <= self._timeout

    def _report_item(self, item: _Item, now: float) -> DiagnosticStatus:
        status = item.status
        level = status.level if OK <= status.level <= STALE else ERROR
        return DiagnosticStatus(
            level=STALE if self._is_stale(item, now) else level,
            name=join_path(self.path, output_name(status.name, self._removed_prefixes)),
            message=status.message,
            hardware_id=status.hardware_id,
            values=status.values,
        )

    def _sum_up(self, levels: list[int]) -> tuple[int, str]:
        """Return the level and the message for items of these levels."""
        level = combine(levels)
        if not levels and self._num_items != 0:
            level = STALE
        if self._num_items and not levels:
            return level, f"No items found, expected {self._num_items}"
        if self._num_items and len(levels) != self._num_items:
            return max(level, ERROR), f"Expected {self._num_items}, found {len(levels)}"
        return level, _LEVEL_WORDS[level]


class DiscardAnalyzer(Analyzer):
    """Matches items, but reports nothing.

    Args:
        path, title: see `Analyzer`.
        matcher: decides which items belong to it.
    """

    def __init__(self, path: str, title: str, matcher: Matcher) -> None:
        super().__init__(path, title)
        self._matcher = matcher

    def analyze(self, status: Any, now: float) -> bool:
        """Return whether a status belongs to this analyzer."""
        return self._matcher.matches(status.name)


class OtherAnalyzer(GenericAnalyzer):
    """Collects the items that match no other analyzer.

    Args:
        base_path: the analyzer's parent path in the tree.
        now: the time in seconds.
        as_errors: whether such items are errors.
    """

    def __init__(self, base_path: str, now: float, as_errors: bool) -> None:
        super().__init__(f"{base_path}/Other", "Other", Matcher(), now, discard_stale=True)
        self._as_errors = as_errors

    def matches(self, name: str) -> bool:
        """Return True."""
        return True

    def report(self, now: float) -> list[DiagnosticStatus]:
        """Return the statuses of the items, and one that summarizes them; nothing if there are no items."""
        statuses = super().report(now)
        if len(statuses) < 2 and not self.ignored_some(now):
            return []
        if self._as_errors:
            statuses[0].level, statuses[0].message = ERROR, 'Unanalyzed items found in "Other"'
        return statuses


class AnalyzerGroup(Analyzer):
    """Combines analyzers.

    Args:
        path, title: see `Analyzer`. If the path is "/", there is no status that summarizes the others.
        analyzers: the analyzers in the group.
        problems: for each analyzer that could not be created, the last part of its path and the reason.

    Attributes:
        analyzers, problems: the analyzers, and the statuses of those that could not be created.
    """

    def __init__(
        self, path: str, title: str, analyzers: Sequence[Analyzer], problems: Sequence[tuple[str, str]] = ()
    ) -> None:
        super().__init__(path, title)
        self.analyzers = list(analyzers)
        self.problems = [make_header(join_path(path, name), STALE, [], message) for name, message in problems]

    def analyze(self, status: Any, now: float) -> bool:
        """Pass a status to all analyzers, and return whether it belongs to one of them."""
        taken = [analyzer.analyze(status, now) for analyzer in self.analyzers]
        return any(taken)

    def report(self, now: float) -> list[DiagnosticStatus]:
        """Return the statuses of all analyzers, one that summarizes them, and the problems."""
        statuses, headers = [], []
        for analyzer in self.analyzers:
            report = analyzer.report(now)
            headers += [(analyzer.title, status) for status in report if status.name == analyzer.path]
            statuses += report
        if not self.analyzers:
            return [make_header("/AnalyzerGroup" if self.path == "/" else self.path, ERROR, [], "No analyzers")]
        if self.path != "/":
            level = combine(status.level for _, status in headers)
            statuses.append(make_header(self.path, level, [(title, status.message) for title, status in headers]))
        return statuses + self.problems


def make_header(path: str, level: int, values: Iterable[tuple[str, str]], message: str = "") -> DiagnosticStatus:
    """Return a status with keys and values; its message is by default the word for the level."""
    pairs = [KeyValue(key, value) for key, value in values]
    return DiagnosticStatus(level=level, name=path, message=message or _LEVEL_WORDS[level], values=pairs)


def _size_of(status: Any) -> int:
    """Return the approximate size of a status in characters."""
    pairs = sum(_PAIR_SIZE + len(pair.key) + len(pair.value) for pair in status.values)
    return pairs + len(status.name) + len(status.message) + len(status.hardware_id)


def _missing_status(name: str) -> DiagnosticStatus:
    return DiagnosticStatus(level=STALE, name=name, message=_MISSING)
