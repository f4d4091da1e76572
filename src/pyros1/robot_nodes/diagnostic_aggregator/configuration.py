"""Creates analyzers from the parameters of aggregator_node (no I/O)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.diagnostic_aggregator.analyzers import (
    DEFAULT_TIMEOUT,
    Analyzer,
    AnalyzerGroup,
    DiscardAnalyzer,
    GenericAnalyzer,
    IgnoreAnalyzer,
)
from pyros1.robot_nodes.diagnostic_aggregator.matching import Matcher, join_path
from pyros1.robot_nodes.diagnostic_aggregator.patterns import NamePattern, PatternError
from pyros1.robot_nodes.shared.parameters import PrivateParameters

PACKAGE = "diagnostic_aggregator"
MATCHING_PARAMETERS = ("find_and_remove_prefix", "startswith", "name", "contains", "expected", "regex")
_MAX_DEPTH = 50
_INIT_FAILED = "Analyzer init failed"
_NO_TYPE = "No Analyzer type given"

Report = Callable[[str], object]


class ConfigurationError(Error):
    """An analyzer cannot be created."""


class AnalyzerFactory:
    """Creates analyzers.

    Args:
        report: called with a one-line message about each parameter that cannot be used.
    """

    def __init__(self, report: Report) -> None:
        self._report = report

    def make_group(
        self, path: str, title: str, specifications: object, namespace: str, now: float, depth: int = 0
    ) -> AnalyzerGroup:
        """Return a group of analyzers; those that cannot be created are reported and left out.

        Args:
            path, title: see `Analyzer`.
            specifications: the parameters of each analyzer, by a name that only determines the order.
            namespace: the namespace of these parameters, for reports.
            now: the time in seconds.
            depth: the number of groups that contain this group.
        """
        analyzers: list[Analyzer] = []
        problems: list[tuple[str, str]] = []
        if not isinstance(specifications, Mapping):
            specifications = {}
        for name, specification in sorted(specifications.items()):
            place = f"{namespace}/{name}"
            if not isinstance(specification, Mapping) or not isinstance(specification.get("type"), str):
                self._report(f"{place} has no type: set it to {PACKAGE}/GenericAnalyzer, for example")
                problems.append((name, _NO_TYPE))
                continue
            try:
                analyzer = self._make_analyzer(path, specification, place, now, depth)
            except ConfigurationError as error:
                self._report(f"{place} is ignored: {error}")
                problems.append((name, _INIT_FAILED))
            else:
                analyzers += [analyzer] if analyzer is not None else []
        if not analyzers:
            self._report(f"{namespace} has no analyzers that can be used")
        return AnalyzerGroup(path, title, analyzers, problems)

    def _make_analyzer(
        self, base_path: str, specification: Mapping[str, Any], place: str, now: float, depth: int
    ) -> Analyzer | None:
        """Return an analyzer; None if the type does not exist.

        Raises:
            ConfigurationError: a parameter is missing.
        """
        package, _, kind = specification["type"].rpartition("/")
        if package not in ("", PACKAGE) or kind not in _KINDS:
            text = one_line(specification["type"], 100)
            self._report(f"{place} is ignored: there is no analyzer {text}, only {', '.join(_KINDS)} of {PACKAGE}")
            return None
        if kind == "IgnoreAnalyzer":
            return IgnoreAnalyzer("", "")
        title = specification.get("path", "" if kind == "AnalyzerGroup" else None)
        if not isinstance(title, str):
            raise ConfigurationError("it has no path, which says where in the tree it is")
        path = join_path(base_path, title) if title or kind != "AnalyzerGroup" else base_path
        if kind == "AnalyzerGroup":
            if depth >= _MAX_DEPTH:
                raise ConfigurationError("too many groups within groups")
            group = self.make_group(path, title, specification.get("analyzers"), f"{place}/analyzers", now, depth + 1)
            if group.problems or not group.analyzers:
                raise ConfigurationError("not all of its analyzers can be used")  # as in stock ROS, all or none
            return group
        return self._make_generic(kind, path, title, PrivateParameters(specification, self._report, place), place, now)

    def _make_generic(
        self, kind: str, path: str, title: str, parameters: PrivateParameters, place: str, now: float
    ) -> Analyzer:
        found_prefixes, startswith, names, contains, expected, regexes = (
            self._texts(parameters, name) for name in MATCHING_PARAMETERS
        )
        matcher = Matcher(
            frozenset([*names, *expected]),
            (*startswith, *found_prefixes),
            tuple(contains),
            tuple(self._patterns(regexes, place)),
        )
        if not matcher:
            raise ConfigurationError(f"it matches nothing: set one of {', '.join(MATCHING_PARAMETERS)}")
        if kind == "DiscardAnalyzer":
            return DiscardAnalyzer(path, title, matcher)
        timeout = parameters.number("timeout", DEFAULT_TIMEOUT)
        num_items = parameters.integer("num_items", -1)
        discard_stale = parameters.flag("discard_stale", False)
        if discard_stale and timeout <= 0:
            self._report(f"{place} discards nothing, since items without a timeout are never stale")
        return GenericAnalyzer(
            path,
            title,
            matcher,
            now,
            removed_prefixes=[*found_prefixes, *self._texts(parameters, "remove_prefix")],
            expected=expected,
            timeout=timeout,
            num_items=num_items if num_items >= 0 else None,
            discard_stale=discard_stale,
        )

    def _texts(self, parameters: PrivateParameters, name: str) -> list[str]:
        """Return a parameter that is a string or a list of strings, as a list."""
        value = parameters.value(name)
        if value is None or isinstance(value, str):
            return [] if value is None else [value]
        if isinstance(value, list) and all(isinstance(each, str) for each in value):
            return value
        return parameters.report_invalid(name, value, "a string or a list of strings", [])

    def _patterns(self, regexes: list[str], place: str) -> list[NamePattern]:
        patterns = []
        for text in regexes:
            try:
                patterns.append(NamePattern(text))
            except PatternError as error:
                self._report(f"{place} ignores the regular expression {one_line(repr(text), 100)}: {error}")
        return patterns


_KINDS = ("GenericAnalyzer", "AnalyzerGroup", "DiscardAnalyzer", "IgnoreAnalyzer")
