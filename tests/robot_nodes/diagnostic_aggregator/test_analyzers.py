from __future__ import annotations

from typing import Any

import pytest

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from pyros1.robot_nodes.diagnostic_aggregator.aggregator import Aggregator
from pyros1.robot_nodes.diagnostic_aggregator.analyzers import (
    ERROR,
    MAX_SIZE,
    OK,
    STALE,
    WARN,
    Analyzer,
    AnalyzerGroup,
    DiscardAnalyzer,
    GenericAnalyzer,
    IgnoreAnalyzer,
    OtherAnalyzer,
    combine,
)
from pyros1.robot_nodes.diagnostic_aggregator.matching import Matcher


def generic(*parts: str, path: str = "/A", **options: Any) -> GenericAnalyzer:
    matcher = Matcher(frozenset(options.get("expected", ())), parts=parts)
    return GenericAnalyzer(path, path[1:], matcher, 100.0, **options)


def feed(analyzer: Analyzer, now: float, **levels: int) -> None:
    for name, level in levels.items():
        analyzer.analyze(DiagnosticStatus(level=level, name=name, message=f"{name} says"), now)


def shown(analyzer: Analyzer, now: float) -> list[tuple[str, int, str]]:
    return [(status.name, status.level, status.message) for status in analyzer.report(now)]


def values(analyzer: Analyzer, now: float) -> list[tuple[str, str]]:
    return [(pair.key, pair.value) for pair in analyzer.report(now)[0].values]


def test_stale_counts_as_an_error_unless_all_are_stale() -> None:
    assert [combine(levels) for levels in ([], [OK, WARN], [STALE, STALE], [OK, STALE])] == [OK, WARN, STALE, ERROR]


def test_items_are_summed_up_in_the_order_of_their_names() -> None:
    analyzer = generic("n")
    assert shown(analyzer, 100.0) == [("/A", STALE, "Stale")]
    feed(analyzer, 100.0, n2=WARN, n1=OK, other=ERROR)
    assert shown(analyzer, 101.0) == [("/A", WARN, "Warning"), ("/A/n1", OK, "n1 says"), ("/A/n2", WARN, "n2 says")]
    assert values(analyzer, 101.0) == [("n1", "n1 says"), ("n2", "n2 says")]
    feed(analyzer, 104.0, n1=OK)
    assert shown(analyzer, 105.5)[0] == ("/A", ERROR, "Error"), "n2 is stale"
    assert shown(analyzer, 109.5) == [("/A", STALE, "Stale"), ("/A/n1", STALE, "n1 says"), ("/A/n2", STALE, "n2 says")]
    feed(analyzer, 110.0, n1=7)
    assert shown(analyzer, 110.0)[1] == ("/A/n1", ERROR, "n1 says"), "there is no level 7"


def test_an_item_keeps_its_hardware_and_values() -> None:
    analyzer = generic("n")
    analyzer.analyze(DiagnosticStatus(name="n", hardware_id="7", values=[KeyValue("volts", "12")]), 100.0)
    item = analyzer.report(100.0)[1]
    assert (item.hardware_id, item.values) == ("7", [KeyValue("volts", "12")])


def test_without_a_timeout_nothing_becomes_stale() -> None:
    analyzer = generic("n", timeout=0.0, discard_stale=True)
    feed(analyzer, 100.0, n=OK)
    assert shown(analyzer, 1e9) == [("/A", OK, "OK"), ("/A/n", OK, "n says")]


def test_the_number_of_items() -> None:
    two, none = generic("n", num_items=2), generic("n", num_items=0)
    assert shown(two, 100.0) == [("/A", STALE, "No items found, expected 2")]
    assert shown(none, 100.0) == [("/A", OK, "OK")]
    for analyzer in (two, none):
        feed(analyzer, 100.0, n1=OK)
    assert shown(two, 100.0)[0] == ("/A", ERROR, "Expected 2, found 1")
    assert shown(two, 200.0)[0] == ("/A", STALE, "Expected 2, found 1")
    assert shown(none, 100.0)[0] == ("/A", OK, "OK")
    feed(two, 100.0, n2=OK)
    assert shown(two, 100.0)[0] == ("/A", OK, "OK")


def test_expected_items() -> None:
    analyzer = generic(expected=["b", "a"])
    assert shown(analyzer, 100.0) == [("/A", STALE, "Stale"), ("/A/a", STALE, "Missing"), ("/A/b", STALE, "Missing")]
    feed(analyzer, 100.0, b=OK)
    assert shown(analyzer, 100.0)[:2] == [("/A", ERROR, "Error"), ("/A/a", STALE, "Missing")]


def test_stale_items_are_discarded() -> None:
    """The summary goes, too, when it has been stale for as long as the timeout; expected items are still missing."""
    analyzer = generic("n", timeout=2.0, discard_stale=True)
    assert shown(analyzer, 102.0) and not shown(analyzer, 102.1)
    feed(analyzer, 103.0, n1=OK)
    feed(analyzer, 104.0, n2=OK)
    assert len(shown(analyzer, 104.0)) == 3
    assert shown(analyzer, 105.5) == [("/A", OK, "OK"), ("/A/n2", OK, "n2 says")]
    assert shown(analyzer, 106.5) == shown(analyzer, 107.5) == [("/A", STALE, "Stale")]
    assert not shown(analyzer, 107.6)

    analyzer = generic(timeout=2.0, discard_stale=True, expected=["b", "a"])
    feed(analyzer, 100.0, a=OK, b=OK)
    feed(analyzer, 102.0, a=OK)
    some, every = (f"{amount} diagnostics are stale - setting combined level to" for amount in ("Some", "All"))
    assert shown(analyzer, 103.0) == [
        ("/A", ERROR, f"{some} ERROR."),
        ("/A/a", OK, "a says"),
        ("/A/b", STALE, "Missing"),
    ]
    assert values(analyzer, 103.0) == [("a", "a says"), ("b", "Missing")]
    missing = [("/A/b", STALE, "Missing"), ("/A/a", STALE, "Missing")]
    assert shown(analyzer, 104.5) == [("/A", STALE, f"{every} STALE."), *missing]
    assert shown(analyzer, 105.1) == missing


def test_groups() -> None:
    first, second = generic("n", path="/G/1"), generic("m", path="/G/2")
    group = AnalyzerGroup("/G", "group", [first, second], [("bad", "broken")])
    feed(group, 100.0, n=OK)
    assert shown(group, 100.0) == [
        ("/G/1", OK, "OK"),
        ("/G/1/n", OK, "n says"),
        ("/G/2", STALE, "Stale"),
        ("/G", ERROR, "Error"),
        ("/G/bad", STALE, "broken"),
    ]
    assert [(pair.key, pair.value) for pair in group.report(100.0)[3].values] == [("G/1", "OK"), ("G/2", "Stale")]
    assert [name for name, *_ in shown(AnalyzerGroup("/", "", [generic("n")]), 100.0)] == ["/A"]
    assert shown(AnalyzerGroup("/", "", []), 100.0) == [("/AnalyzerGroup", ERROR, "No analyzers")]


def test_what_no_analyzer_takes() -> None:
    group = AnalyzerGroup(
        "/", "", [generic("n"), DiscardAnalyzer("", "", Matcher(parts=("d",))), IgnoreAnalyzer("", "")]
    )
    for as_errors, header in (
        (False, ("/Other", WARN, "Warning")),
        (True, ("/Other", ERROR, 'Unanalyzed items found in "Other"')),
    ):
        aggregator = Aggregator(group, "", as_errors, 100.0)
        statuses = [DiagnosticStatus(name=name, level=level) for name, level in (("n", 0), ("d", 2), ("x", 1))]
        aggregator.receive(statuses, 101.0)
        tree, state = aggregator.report(102.0)
        assert [(status.name, status.level, status.message) for status in tree[2:]] == [header, ("/Other/x", 1, "")]
        assert (state.name, state.level) == ("toplevel_state", header[1])
        tree, state = aggregator.report(110.0)
        assert [status.name for status in tree] == ["/A", "/A/n"] and state.level == STALE


def test_senders_cannot_fill_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.robot_nodes.diagnostic_aggregator.analyzers.MAX_ITEMS", 300)
    analyzer = generic("n")
    for number in range(305):
        assert analyzer.analyze(DiagnosticStatus(name=f"n{number}"), 100.0)
    level, message = shown(analyzer, 100.0)[0][1:]
    assert len(shown(analyzer, 100.0)) == 301
    assert level == WARN and message.startswith("Diagnostics were ignored, since there are more than 300 items")
    feed(analyzer, 100.0, n0=ERROR)
    assert shown(analyzer, 100.0)[0][1] == ERROR, "what is known is still updated"
    feed(analyzer, 106.0, **{f"n{number}": OK for number in range(300)})
    assert shown(analyzer, 106.0)[0] == ("/A", OK, "OK")


def test_senders_cannot_fill_the_memory_with_large_items() -> None:
    part = "x" * (MAX_SIZE // 10 - 1000)
    for analyzer in (generic("n"), OtherAnalyzer("", 100.0, as_errors=False)):
        for number in range(20):
            analyzer.analyze(DiagnosticStatus(name=f"n{number}", values=[KeyValue("k", part)]), 100.0)
        assert len(shown(analyzer, 100.0)) == 11 and shown(analyzer, 100.0)[0][1] == WARN
        feed(analyzer, 101.0, **{f"n{number}": OK for number in range(20)})
        assert len(shown(analyzer, 101.0)) == 21, "small ones have room again"
        analyzer.analyze(DiagnosticStatus(name="n1", message="x" * (MAX_SIZE + 1)), 104.0)
        assert shown(analyzer, 104.0)[0][1] == WARN
    other = OtherAnalyzer("", 100.0, as_errors=False)
    other.analyze(DiagnosticStatus(name="n", hardware_id="x" * (MAX_SIZE + 1)), 100.0)
    assert [name for name, *_ in shown(other, 100.0)] == ["/Other"] and not other.report(106.0)
    discarding = generic("n", discard_stale=True)
    for now in (100.0, 200.0):
        discarding.report(now)
        for number in range(10):
            discarding.analyze(DiagnosticStatus(name=f"n{now}{number}", message=part), now)
        assert shown(discarding, now)[0][1] == OK, "what was discarded leaves room"


def test_what_came_before_time_jumped_back_is_stale() -> None:
    analyzer, discarding = generic("n"), generic("n", discard_stale=True)
    for each in (analyzer, discarding):
        feed(each, 1000.0, n1=OK, n2=OK)
        feed(each, 3.0, n2=OK)
    assert shown(analyzer, 4.0)[1:] == [("/A/n1", STALE, "n1 says"), ("/A/n2", OK, "n2 says")]
    assert shown(discarding, 4.0)[1:] == [("/A/n2", OK, "n2 says")]
