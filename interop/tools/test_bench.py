"""The benchmarks' page, history and quick form (`interop/bench`). CI runs the quick form itself, see `tests/run`."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from harness import INTEROP

BENCH = INTEROP / "bench"
ABOUT = {"date": "2026-01-01", "commit": "abc", "python": "3.11", "cpu": "<fast>", "cores": 2, "system": "Linux"}
ABOUT |= {"runs": 2, "seconds": 1.0, "load": 0.5}


@pytest.fixture(autouse=True)
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The programs of the bench can be imported, and nothing of them stays."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(str(BENCH))
    yield
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(BENCH)):
            del sys.modules[name]


class Turn:
    """A step of the bench, for results by hand."""

    label = "by hand"

    def run(self, bench: Any) -> dict[str, float]:
        raise NotImplementedError


def reported(figures: dict[str, list[float | None]], bound: float, less: bool = False) -> dict[str, Any]:
    """The report of one row with these figures per column; None is a turn that failed."""
    from model import Goal, Row
    from table import row_report

    steps = {column: Turn() for column in figures}
    results = {
        steps[column]: [None if one is None else {"x": one} for one in turns] for column, turns in figures.items()
    }
    row = Row("group", "a <row>", "ms", "x", steps, (Goal(bound, "roscpp"),), less)
    return {"about": ABOUT, "rows": [row_report(row, results)]}  # type: ignore[arg-type]


class Reader(HTMLParser):
    """The texts and the elements of a page; wants each element to be closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self._open: list[str] = []
        self.feed(page)
        assert self._open == [], f"not closed: {self._open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in ("meta", "line"):
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_ratios_of_turns_leave_out_those_that_failed() -> None:
    row = reported({"ours": [2.0, None, 8.0], "roscpp": [4.0, 5.0, 8.0]}, 1.5, less=True)["rows"][0]
    assert row["ratios"] == {"roscpp": [2.0, 1.0]}
    row = reported({"ours": [2.0, 3.0, 8.0], "roscpp": [4.0, 0.0, 8.0]}, 1.5)["rows"][0]
    assert row["ratios"] == {"roscpp": [0.5, 1.0]}


def test_the_page_shows_rows_goals_and_misses() -> None:
    from page import history_line, page

    report = reported({"ours": [10.0, 30.0], "roscpp": [10.0, 10.0]}, 4)
    first = json.loads(history_line(report))
    html = page(report, [first])
    seen = Reader(html)
    text = " ".join(seen.texts)
    assert "0 of 1 goals are met" in text
    assert "group: a <row>" in text and "goal >= 4 x roscpp" in text
    assert "<fast>" in text
    dots = [attributes for tag, attributes in seen.elements if tag == "circle"]
    bars = [attributes for tag, attributes in seen.elements if tag == "line" and "range" in (attributes["class"] or "")]
    goals = [attributes for tag, attributes in seen.elements if tag == "line" and "goal" in (attributes["class"] or "")]
    assert len(dots) == len(bars) == len(goals) == 1
    left, right = float(bars[0]["x1"] or 0), float(bars[0]["x2"] or 0)
    assert left < float(dots[0]["cx"] or 0) < right < float(goals[0]["x1"] or 0)
    assert not any(tag == "polyline" for tag, _ in seen.elements), "one run has no history"


def test_the_page_shows_earlier_runs() -> None:
    from page import history_line, page

    report = reported({"ours": [40.0, 60.0], "roscpp": [10.0, 10.0]}, 4)
    earlier = json.loads(history_line(reported({"ours": [10.0], "roscpp": [10.0]}, 4)))
    earlier["about"]["commit"] = "0ld"
    seen = Reader(page(report, [earlier, json.loads(history_line(report))]))
    assert "1 of 1 goals are met" in " ".join(seen.texts)
    [trend] = [attributes for tag, attributes in seen.elements if tag == "polyline"]
    (_, before), (_, after) = [map(float, point.split(",")) for point in (trend["points"] or "").split()]
    assert after < before, "better is higher"
    assert "0ld: 1.00, abc: 5.00" in seen.texts


def test_a_row_without_figures_is_shown_as_failed() -> None:
    from page import history_line, page

    report = reported({"ours": [None], "roscpp": [1.0]}, 4)
    text = " ".join(Reader(page(report, [json.loads(history_line(report))])).texts)
    assert "failed" in text and "no figure" in text


def test_a_history_that_is_none_is_an_error(tmp_path: Path) -> None:
    from page import read_history

    assert read_history(tmp_path / "none") == []
    for text in ("{}", "[]", "3", "nothing", '{"about": 3, "rows": {}}', '{"about": {"date": ""}, "rows": 1}'):
        file = tmp_path / "history"
        file.write_text('{"about": {"date": ""}, "rows": {}}\n' + text)
        with pytest.raises(ValueError, match="history:2: not a run"):
            read_history(file)


def test_the_quick_form_has_rows_of_nearly_all_groups() -> None:
    from rows import QUICK, all_rows

    names = {f"{row.group}: {row.name}": row.group for row in all_rows()}
    assert set(names) >= QUICK
    assert {names[name] for name in QUICK} >= set(names.values()) - {"launch", "bags"}
    program = [sys.executable, str(BENCH / "run.py"), "--quick", "--list"]
    told = subprocess.run(program, capture_output=True, text=True, check=True, timeout=60)
    listed = [line for line in told.stdout.splitlines() if not line.startswith(" ")]
    assert sorted(line.partition(" [")[0] for line in listed) == sorted(QUICK)


def test_a_machine_without_git(monkeypatch: pytest.MonkeyPatch) -> None:
    from table import commit

    monkeypatch.setenv("PATH", "")
    assert commit() == "?"
